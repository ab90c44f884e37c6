// SPDX-License-Identifier: Apache-2.0
import { fitted, panned, screenToWorld, viewOf, worldToScreen, zoomedAt, type Camera, type Point, type Size } from '../../scene/camera';
import { listen } from '../../scene/input';
import { defaultClasses, parseColour, readPalette, type Palette } from '../../scene/palette';
import { Signal } from '../../signal';
import { onColoursChange } from '../../ui/theme';
import { UNITS, type Box, type Units } from '../lattice';
import type { EditSession } from '../session';
import type { Style } from '../shapes';
import { CornerPen, pensOf, type Pen } from '../tools/pens';
import type { PointerReport } from '../tools/pointer';
import { radiusOf, type ToolSettings } from '../tools/settings';
import { css, drawBox, drawGrid, drawOutline, drawPointer, drawRing, drawSketch, type MarkColours, type Outline, type Project } from './marks';
import { coloursOf, Picture } from './picture';

const MAX_SCALE = 64; // pixels for a cell
const MIN_SCALE = 0.01;
const GRID_SCALE = 12;
const NEAR_PX = 8;
const PAN_PX = 64;
const SAMPLES = 600;

export interface BoardEvents {
  // Where the pointer is, in cells.
  hover(at: Point | undefined): void;
  // Why something has not been drawn; empty: it has.
  said(text: string): void;
  area(ring: Units[]): void;
}

// The picture of a draft on a canvas, and the pointer over it. Its world is the lattice, in cells.
export class Board {
  readonly canvas = document.createElement('canvas');
  readonly cameraChanged = new Signal();
  camera: Camera = { x: 0, y: 0, scale: 1 };
  size: Size = { width: 1, height: 1 };
  // What the page shows besides.
  outlines: readonly Outline[] = [];
  boxes: readonly Box[] = [];
  // JavaScript of the last frames with what the pointer did before them, ms.
  readonly frameMs: number[] = [];
  private readonly context = this.canvas.getContext('2d', { alpha: false })!;
  private readonly picture: Picture;
  private readonly pens: ReturnType<typeof pensOf>;
  private palette!: Palette;
  private marks!: MarkColours;
  private pen: Pen | undefined;
  private pointer: Point | undefined;
  private isTinted = true;
  private isSpaceDown = false;
  private isFitted = false;
  // Of the canvas in the window.
  private middle: Point | undefined;
  private isCurrent = false;
  private busyMs = 0;
  private request = 0;
  private readonly stops: (() => void)[];
  private readonly observer = new ResizeObserver(() => this.resize());

  constructor(readonly session: EditSession, readonly settings: ToolSettings, private readonly report: PointerReport, private readonly events: BoardEvents) {
    const style = (): Style => {
      const { value, onlyWhere, invisible } = settings.get();
      return { value, onlyWhere, invisible, author: session.author() };
    };
    this.pens = pensOf({ session, settings: settings.get, style, area: (ring) => events.area(ring) }, () => (NEAR_PX / this.camera.scale) * UNITS);
    this.picture = new Picture(session.draft.overlay.tiles);
    session.touched = (...what) => {
      this.picture.touch(...what);
      this.touch();
    };
    Object.assign(this.canvas, { className: 'edit-canvas', tabIndex: 0 });
    this.canvas.setAttribute('role', 'application');
    this.canvas.setAttribute('aria-label', 'Map to draw on. Arrow keys move, plus and minus zoom, 0 shows all. What the pointer draws can be drawn by numbers, too.');
    this.readTheme();
    this.stops = [this.listen(), onColoursChange(() => this.readTheme()), settings.changed.subscribe(() => this.onSettings()), session.changed.subscribe(() => this.touch())];
    this.observer.observe(this.canvas);
  }

  close() {
    for (const stop of this.stops) stop();
    this.observer.disconnect();
    cancelAnimationFrame(this.request);
    this.session.touched = () => {};
  }

  setCamera(camera: Camera) {
    this.camera = { ...camera, scale: Math.min(MAX_SCALE, Math.max(MIN_SCALE, camera.scale)) };
    this.isFitted = true;
    this.session.tiles.focus = { x: this.camera.x * UNITS, y: this.camera.y * UNITS };
    this.cameraChanged.tell();
    this.touch();
  }

  // All of the map, or a part of it.
  fit(box = this.session.box): boolean {
    if (!box) return false;
    const bounds = { minX: box.firstColumn, minY: box.firstRow, maxX: box.firstColumn + box.width, maxY: box.firstRow + box.height };
    this.setCamera(fitted(bounds, this.size, Math.min(48, this.size.width / 12)));
    return true;
  }

  zoom(factor: number) {
    this.zoomAt({ x: this.size.width / 2, y: this.size.height / 2 }, factor);
  }

  touch() {
    this.isCurrent = false;
    if (this.request === 0) this.request = requestAnimationFrame(() => this.frame());
  }

  // Whether the canvas shows all that is known.
  get isSettled(): boolean {
    return this.isCurrent && this.session.isSettled;
  }

  // Gives up what is being drawn.
  cancel() {
    (this.pen ?? this.pens[this.settings.get().tool]).cancel();
    this.pen = undefined;
    this.touch();
  }

  // The polygon that is being drawn is complete, or loses its last corner.
  finish() {
    const pen = this.pens[this.settings.get().tool];
    if (pen instanceof CornerPen) this.say(pen.close());
  }
  back() {
    const pen = this.pens[this.settings.get().tool];
    if (pen instanceof CornerPen) pen.back();
    this.touch();
  }

  set space(isDown: boolean) {
    this.isSpaceDown = isDown;
    this.canvas.style.cursor = isDown ? 'grab' : '';
  }

  // A place of the canvas in units.
  units(at: Point): Units {
    const { x, y } = screenToWorld(this.camera, this.size, at);
    return { x: Math.floor(x * UNITS), y: Math.floor(y * UNITS) };
  }

  private listen() {
    const { canvas } = this;
    const busy = <T>(act: () => T): T => {
      const begin = performance.now();
      try {
        return act();
      } finally {
        this.busyMs += performance.now() - begin;
      }
    };
    return listen(canvas, {
      pan: (dx, dy) => this.setCamera(panned(this.camera, dx, dy)),
      zoom: (at, factor) => this.zoomAt(at, factor),
      hover: (at) => busy(() => this.hover(at)),
      click: () => {},
      open: () => this.finish(),
      menu: () => false,
      key: (key) => this.key(key),
      pen: {
        begin: (at, event) => busy(() => this.begin(at, event)),
        move: (at) => busy(() => {
          this.pen?.move(at.map((one) => this.units(one)));
          this.hover(at.at(-1));
        }),
        end: (at) => busy(() => {
          this.say(this.pen?.end(this.units(at)));
          this.pen = undefined;
        }),
        cancel: () => this.cancel(),
      },
    });
  }

  private begin(at: Point, event: PointerEvent): boolean {
    if (event.button !== 0 || this.isSpaceDown) return false;
    if (!this.session.isOpen) {
      this.say('This draft takes no more edits.');
      return false;
    }
    this.pen = this.pens[this.settings.get().tool];
    this.pen.begin(this.units(at));
    this.hover(at);
    return true;
  }

  private say(problem: string | undefined) {
    this.events.said(problem ?? '');
    this.touch();
  }

  private hover(at: Point | undefined) {
    this.pointer = at;
    const pen = this.pens[this.settings.get().tool];
    if (pen instanceof CornerPen && !this.pen) pen.hover(at && this.units(at));
    this.report.at(at && this.units(at), this.settings.get().tool);
    this.events.hover(at && screenToWorld(this.camera, this.size, at));
    this.touch();
  }

  private zoomAt(at: Point, factor: number) {
    const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, this.camera.scale * factor));
    this.setCamera(zoomedAt(this.camera, this.size, at, scale / this.camera.scale));
  }

  private key(key: string): boolean {
    const pan: Record<string, [number, number]> = { ArrowLeft: [PAN_PX, 0], ArrowRight: [-PAN_PX, 0], ArrowUp: [0, PAN_PX], ArrowDown: [0, -PAN_PX] };
    const step = pan[key];
    if (step) this.setCamera(panned(this.camera, ...step));
    else if (key === '+' || key === '=') this.zoom(1.5);
    else if (key === '-') this.zoom(1 / 1.5);
    else if (key === '0') return this.fit();
    else return false;
    return true;
  }

  private onSettings() {
    if (this.settings.get().isTinted !== this.isTinted) this.readTheme();
    this.touch();
  }

  private readTheme() {
    this.isTinted = this.settings.get().isTinted;
    this.palette = readPalette(defaultClasses);
    const { colour, background } = this.palette;
    const style = getComputedStyle(document.documentElement);
    const rgb = (name: string) => parseColour(style.getPropertyValue(`--scene-${name}`));
    this.picture.colours = coloursOf(background.slice(0, 3).map((part) => Math.round(part * 255)), rgb('free'), rgb('occupied'), rgb('select'), this.isTinted);
    this.picture.touchAll();
    this.marks = { grid: css(colour.grid), line: css(colour.select), halo: css(colour.halo), other: css(colour.candidate), area: css(colour.link) };
    this.touch();
  }

  private frame() {
    this.request = 0;
    const begin = performance.now();
    if (!this.isFitted && this.size.width > 1) this.fit();
    const { context, canvas } = this;
    const ratio = canvas.width / this.size.width;
    const size = { width: canvas.width, height: canvas.height };
    const camera = { ...this.camera, scale: this.camera.scale * ratio };
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = getBackground(this.palette);
    context.fillRect(0, 0, size.width, size.height);
    this.isCurrent = this.picture.draw(context, camera, size);
    this.drawMarks(ratio, (x, y) => {
      const at = worldToScreen(camera, size, { x, y });
      return [at.x, at.y];
    });
    if (!this.isCurrent && this.request === 0) this.request = requestAnimationFrame(() => this.frame());
    if (this.frameMs.push(performance.now() - begin + this.busyMs) > SAMPLES) this.frameMs.shift();
    this.busyMs = 0;
  }

  private drawMarks(ratio: number, project: Project) {
    const { context, marks, session, camera, pointer } = this;
    if (camera.scale >= GRID_SCALE) {
      const { minX, minY, maxX, maxY } = viewOf(camera, this.size);
      drawGrid(context, marks, project, minX, minY, maxX, maxY, ratio);
    }
    if (session.box) drawBox(context, marks, project, session.box, marks.grid, ratio);
    for (const outline of this.outlines) drawOutline(context, marks, project, outline, ratio);
    for (const box of this.boxes) drawBox(context, marks, project, box, marks.line, ratio);
    for (const { clientId, author, pointer: at } of session.presences) {
      if (clientId !== session.clientId && at) drawPointer(context, marks, project(at.x / UNITS, at.y / UNITS), author, ratio);
    }
    const settings = this.settings.get();
    const sketch = this.pens[settings.tool].sketch();
    if (sketch) drawSketch(context, marks, project, sketch, ratio);
    if (pointer && settings.tool === 'brush') drawRing(context, marks, [pointer.x * ratio, pointer.y * ratio], (radiusOf(settings) / UNITS) * camera.scale * ratio, ratio);
  }

  private resize() {
    const box = this.canvas.getBoundingClientRect();
    if (box.width === 0 || box.height === 0) return;
    const middle = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
    // The map stays under the pointer when a notice over it comes or goes.
    if (this.isFitted && this.middle) {
      const { x, y, scale } = this.camera;
      this.setCamera({ x: x + (middle.x - this.middle.x) / scale, y: y - (middle.y - this.middle.y) / scale, scale });
    }
    this.middle = middle;
    this.size = { width: box.width, height: box.height };
    this.canvas.width = Math.round(box.width * devicePixelRatio);
    this.canvas.height = Math.round(box.height * devicePixelRatio);
    this.touch();
  }
}

const getBackground = ({ background: [r, g, b] }: Palette) => css([Math.round(r * 255), Math.round(g * 255), Math.round(b * 255)]);

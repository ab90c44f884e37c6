// SPDX-License-Identifier: Apache-2.0
import type { LiveSite } from '../live/site';
import { Signal } from '../signal';
import { onColoursChange } from '../ui/theme';
import { affineOf, apply, united } from './affine';
import { addAreas } from './areas';
import { fitted, panned, screenToWorld, viewOf, zoomedAt, type Bounds, type Camera, type Point, type Size } from './camera';
import { addExplanation, addLinkPoints, addMaps, addRobots, mapBounds } from './drawing';
import { Surface } from './Surface';
import { listen } from './input';
import { CHOICE_MS, Labels } from './labels';
import type { Drawn, Frame, Mark, View } from './model';
import { Motion } from './motion';
import { addMoves } from './moves';
import { Placement } from './placement';
import { thumbnailAffine } from './outlines';
import { addPath, boundsOfPath } from './path';
import { knowsCell, pickIcon } from './pick';
import { addPins } from './pins';
import { addPlans } from './plans';
import { eachPlace, placeOfMap } from './places';
import type { Thumbnail } from './tiles/manifest';

export interface SceneEvents {
  hover?: (what: string | undefined, world: Point | undefined, screen: Point | undefined) => void;
  click?: (what: string | undefined, world: Point) => void;
  open?: (what: string) => void;
  // What can be done at a place: asked for there, or with a key.
  menu?: (world: Point, screen: Point) => void;
  // A second after the last change.
  camera?: (camera: Camera) => void;
  // The person has moved the camera.
  taken?: () => void;
  key?: (key: string) => boolean;
  // The graphics card has dropped the picture, or has given it back.
  lost?: (lost: boolean) => void;
}

const SAMPLES = 600;
const PAN_PX = 64;
const SEEN_MS = 200;

// The picture of a site on one canvas, drawn only when something has changed. It reads the live state each frame; React tells
// it what to look at.
export class Scene {
  readonly labels = new Labels();
  // The camera's scale has changed, whoever changed it.
  readonly scaleChanged = new Signal();
  // The camera or the size of the window has changed, whoever changed it: `shown` is what was drawn last.
  readonly viewChanged = new Signal();
  // What is in view has changed.
  readonly seenChanged = new Signal();
  // Pictures of maps have come.
  readonly picturesChanged = new Signal();
  camera: Camera = { x: 0, y: 0, scale: 20 };
  size: Size = { width: 1, height: 1 };
  shown: { camera: Camera; size: Size } = { camera: this.camera, size: this.size };
  events: SceneEvents = {};
  measured: Point[] = [];
  drawn: Drawn[] = [];
  marks: Mark[] = [];
  readonly frameMs: number[] = [];
  frames = 0;
  drawCalls = 0;

  private view: View = {};
  private site: LiveSite | undefined;
  private readonly motion = new Motion();
  private readonly placement = new Placement();
  private readonly robotsDrawn: Drawn[] = [];
  private seen: ReadonlySet<string> = new Set();
  private pointer: Point | undefined;
  private labelTimer: ReturnType<typeof setTimeout> | undefined;
  private seenTimer: ReturnType<typeof setTimeout> | undefined;
  private dirty = true;
  private fitPending = true;
  private toldLost = false;
  private toldScale = 0;
  private toldPictures = 0;
  private request = 0;
  private unsubscribe = () => {};
  private cameraTimer: ReturnType<typeof setTimeout> | undefined;
  private readonly observer = new ResizeObserver(() => this.resize());
  private readonly surface: Surface;

  constructor(readonly canvas: HTMLCanvasElement, gl: WebGL2RenderingContext) {
    this.surface = new Surface(canvas, gl, () => this.touch());
    listen(canvas, {
      pan: (dx, dy) => this.moveByHand(panned(this.camera, dx, dy)),
      zoom: (at, factor) => this.moveByHand(zoomedAt(this.camera, this.size, at, factor)),
      hover: (at) => this.hover(at),
      click: (at) => this.click(at),
      open: (at) => this.open(at),
      menu: (at) => this.menu(at),
      key: (key) => this.key(key),
    });
    onColoursChange(() => this.surface.readTheme());
    this.observer.observe(canvas);
    // Ages fade also while nothing comes.
    setInterval(() => this.touch(), 1000);
  }

  show(site: LiveSite) {
    if (this.site === site) return;
    this.unsubscribe();
    this.site = site;
    this.motion.clear();
    this.placement.clear();
    this.surface.show(site);
    this.unsubscribe = site.subscribe(() => this.touch());
    this.fitPending = true;
    this.touch();
  }

  look(view: View) {
    if (view.map !== this.view.map) {
      this.fitPending = true;
      this.motion.clear();
      this.placement.clear();
    }
    this.view = view;
    this.touch();
  }

  setCamera(camera: Camera) {
    this.camera = camera;
    this.fitPending = false;
    clearTimeout(this.cameraTimer);
    this.cameraTimer = setTimeout(() => this.events.camera?.(this.camera), 500);
    this.touch();
  }

  // Shows one thing, or all of the level. Returns false while nothing has a place.
  fit(name?: string): boolean {
    const bounds = name === undefined ? this.extent() : this.boundsOf(name);
    if (!bounds) return false;
    this.setCamera(fitted(bounds, this.size, Math.min(48, this.size.width / 12)));
    return true;
  }

  centre(at: Point) {
    this.setCamera({ ...this.camera, ...at, scale: Math.max(this.camera.scale, 10) });
  }

  zoom(factor: number) {
    this.moveByHand(zoomedAt(this.camera, this.size, { x: this.size.width / 2, y: this.size.height / 2 }, factor));
  }

  // Whether the graphics card has dropped the picture.
  get lost(): boolean {
    return this.surface.lost;
  }

  touch() {
    this.dirty = true;
    if (this.request === 0 && this.canvas.isConnected) this.request = requestAnimationFrame(() => this.frame());
  }

  // Another frame, in which the names are chosen anew.
  private touchForLabels() {
    this.labelTimer ??= setTimeout(() => {
      this.labelTimer = undefined;
      this.touch();
    }, CHOICE_MS);
  }

  // Whether the canvas shows all that there is to show: no frame is due and nothing is being fetched.
  settled(): boolean {
    return !this.dirty && this.labelTimer === undefined && !this.fitPending && (this.surface.loader?.idle ?? false);
  }

  // Of the maps, by name; how often they have changed.
  get thumbnails(): ReadonlyMap<string, Thumbnail> {
    return this.surface.loader?.thumbnails ?? new Map();
  }

  get pictures(): number {
    return this.surface.pictures;
  }

  // The names of what is in view, without ghosts: the same set until `seenChanged` tells of another.
  inView(): ReadonlySet<string> {
    return this.seen;
  }

  stats() {
    return { frames: this.frames, drawCalls: this.drawCalls, frameMs: this.frameMs, tileRequests: this.surface.loader?.tileRequests ?? 0, tiles: this.surface.tiles.count };
  }

  placeOf(name: string): Point | undefined {
    const robot = this.site?.robots.get(name);
    if (robot) return this.view.map === undefined ? robot.poseWorld : robot.poseMap;
    const link = this.site?.linkPoints.get(name)?.poseWorldPlace?.pose;
    if (link) return link;
    const bounds = this.boundsOf(name);
    return bounds && { x: (bounds.minX + bounds.maxX) / 2, y: (bounds.minY + bounds.maxY) / 2 };
  }

  private frame() {
    this.request = 0;
    const { site } = this;
    if (!site || !this.dirty || !this.canvas.isConnected) return;
    if (this.surface.lost !== this.toldLost) this.events.lost?.((this.toldLost = this.surface.lost));
    this.dirty = false;
    const begin = performance.now();
    if (this.fitPending && this.surface.hasPictures(site) && this.size.width > 1 && this.fit()) this.fitPending = false;
    if (this.view.follow && this.view.selected !== undefined) {
      const at = this.placeOf(this.view.selected);
      if (at) this.camera = { ...this.camera, x: at.x, y: at.y };
    }
    if (this.camera.scale !== this.toldScale) {
      this.toldScale = this.camera.scale;
      this.scaleChanged.tell();
    }
    if (this.camera !== this.shown.camera || this.size !== this.shown.size) {
      this.shown = { camera: this.camera, size: this.size };
      this.viewChanged.tell();
    }
    const frame: Frame = {
      site, view: this.view, camera: this.camera, size: this.size, window: viewOf(this.camera, this.size), now: begin, wall: Date.now(), drawn: [], marks: [],
    };
    const { glyphs, palette, rasters } = this.surface.begin(site);
    if (this.surface.pictures !== this.toldPictures) {
      this.toldPictures = this.surface.pictures;
      this.picturesChanged.tell();
    }
    const sources = this.surface.sources();
    this.placement.update(frame, sources, palette);
    const missing = addMaps(rasters, glyphs, palette, frame, sources, this.placement.maps);
    addPlans(glyphs, palette, frame);
    addAreas(glyphs, palette, frame);
    addMoves(glyphs, palette, frame, sources);
    addExplanation(glyphs, palette, frame, this.measured);
    addLinkPoints(glyphs, palette, frame, this.placement.links);
    addPath(glyphs, palette, frame);
    addPins(glyphs, palette, frame);
    addRobots(glyphs, palette, frame, this.motion, this.placement.places, this.robotsDrawn);
    this.drawCalls = this.surface.end(frame, missing);
    this.drawn = frame.drawn;
    this.marks = frame.marks;
    if (this.labels.draw(frame)) this.touchForLabels();
    this.seenTimer ??= setTimeout(() => this.see(), SEEN_MS);
    ++this.frames;
    if (this.frameMs.push(performance.now() - begin) > SAMPLES) this.frameMs.shift();
    if (this.motion.moving(performance.now()) || this.placement.moving()) this.touch();
  }

  private see() {
    this.seenTimer = undefined;
    const { width, height } = this.size;
    const seen = new Set<string>();
    for (const item of this.drawn) {
      const outside = Math.abs(item.x - width / 2) > width / 2 + item.halfX || Math.abs(item.y - height / 2) > height / 2 + item.halfY;
      if (!item.ghost && !outside) seen.add(item.name);
    }
    if (seen.size === this.seen.size && [...seen].every((name) => this.seen.has(name))) return;
    this.seen = seen;
    this.seenChanged.tell();
  }

  // Of all that the view has.
  extent(): Bounds | undefined {
    let all: Bounds | undefined;
    const { level, map, path, places } = this.view;
    const add = (bounds: Bounds | undefined) => {
      if (bounds) all = united(all, bounds);
    };
    const point = (p: Point | undefined) => p && add({ minX: p.x, minY: p.y, maxX: p.x, maxY: p.y });
    if (path) add(boundsOfPath(path));
    if (map !== undefined) {
      add(mapBounds(affineOf({ x: 0, y: 0, yaw: 0 }), this.surface.loader?.thumbnails.get(map)));
      return all;
    }
    if (this.site) {
      eachPlace(this.site, this.view, (name, pose) => {
        if (level !== undefined && this.site?.maps.get(name)?.level !== level) return;
        point(pose);
        add(mapBounds(affineOf(pose), this.surface.loader?.thumbnails.get(name)));
      });
    }
    if (places) return all;
    for (const { poseWorldPlace } of this.site?.linkPoints.values() ?? []) point(poseWorldPlace?.pose);
    const { robots } = this.site ?? {};
    for (let row = 0; robots && row < robots.count; ++row) {
      if (robots.placed[row] && (level === undefined || robots.level[row] === level)) point({ x: robots.world[3 * row]!, y: robots.world[3 * row + 1]! });
    }
    return all;
  }

  private boundsOf(name: string): Bounds | undefined {
    const pose = this.site && placeOfMap(this.site, this.view, name);
    if (pose) return mapBounds(affineOf(pose), this.surface.loader?.thumbnails.get(name)) ?? { minX: pose.x, minY: pose.y, maxX: pose.x, maxY: pose.y };
    const at = this.site?.robots.get(name)?.poseWorld ?? this.site?.linkPoints.get(name)?.poseWorldPlace?.pose;
    return at && { minX: at.x - 5, minY: at.y - 5, maxX: at.x + 5, maxY: at.y + 5 };
  }

  private pick(at: Point): string | undefined {
    const icon = pickIcon(this.drawn, at);
    if (icon || this.view.map !== undefined) return icon?.name;
    return this.mapAt(screenToWorld(this.camera, this.size, at));
  }

  // The uppermost map of the level that knows what is there.
  mapAt(world: Point): string | undefined {
    let found: string | undefined;
    for (const [map, pose] of this.placement.places) {
      const level = this.site?.maps.get(map)?.level;
      if (this.view.level !== undefined && level !== this.view.level) continue;
      const thumbnail = this.surface.loader?.thumbnails.get(map);
      if (thumbnail && knowsCell(thumbnail, thumbnailAffine(affineOf(pose), thumbnail), world)) found = map;
    }
    return found;
  }

  // The place in the frame of a map, of a point in the world.
  inMap(map: string, world: Point): Point | undefined {
    const pose = this.placement.places.get(map);
    if (!pose) return undefined;
    const { cos, sin } = { cos: Math.cos(pose.yaw), sin: Math.sin(pose.yaw) };
    return apply({ a: cos, b: -sin, c: sin, d: cos, e: 0, f: 0 }, { x: world.x - pose.x, y: world.y - pose.y });
  }

  private moveByHand(camera: Camera) {
    this.events.taken?.();
    this.setCamera(camera);
  }

  private hover(at: Point | undefined) {
    this.pointer = at;
    const what = at && this.pick(at);
    this.canvas.style.cursor = this.view.measuring ? 'crosshair' : what === undefined ? 'grab' : 'pointer';
    this.events.hover?.(what, at && screenToWorld(this.camera, this.size, at), at);
  }

  private click(at: Point) {
    this.events.click?.(this.view.measuring ? undefined : this.pick(at), screenToWorld(this.camera, this.size, at));
  }

  private open(at: Point) {
    const what = this.pick(at);
    if (what !== undefined) this.events.open?.(what);
  }

  private menu(at: Point): boolean {
    this.events.menu?.(screenToWorld(this.camera, this.size, at), at);
    return this.events.menu !== undefined;
  }

  private key(key: string): boolean {
    const pan: Record<string, [number, number]> = { ArrowLeft: [PAN_PX, 0], ArrowRight: [-PAN_PX, 0], ArrowUp: [0, PAN_PX], ArrowDown: [0, -PAN_PX] };
    const step = pan[key];
    if (step) this.moveByHand(panned(this.camera, ...step));
    else if (key === '+' || key === '=') this.zoom(1.5);
    else if (key === '-') this.zoom(1 / 1.5);
    else if (key === 'c') return this.menu(this.pointer ?? { x: this.size.width / 2, y: this.size.height / 2 });
    else return this.events.key?.(key) ?? false;
    return true;
  }

  private resize() {
    const box = this.canvas.getBoundingClientRect();
    if (box.width === 0 || box.height === 0) return;
    this.size = { width: box.width, height: box.height };
    this.surface.resize(this.size);
    this.touch();
  }
}

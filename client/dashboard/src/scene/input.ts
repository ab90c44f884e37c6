// SPDX-License-Identifier: Apache-2.0
import type { Point } from './camera';

export interface InputTarget {
  pan(dx: number, dy: number): void;
  zoom(at: Point, factor: number): void;
  hover(at: Point | undefined): void;
  click(at: Point): void;
  open(at: Point): void;
  // What can be done at a place. False: nothing, and the browser shows its own menu.
  menu(at: Point): boolean;
  // One of the keys of the scene.
  key(key: string): boolean;
  pen?: Pen;
}

// What a pointer does that draws instead of moving the map. A second finger ends it, and moves the map.
export interface Pen {
  // False: this one moves the map, also with its middle button.
  begin(at: Point, event: PointerEvent): boolean;
  // All places that it passes.
  move(at: Point[]): void;
  end(at: Point): void;
  cancel(): void;
}

const LINE_PX = 16;
const PAGE_PX = 400;
const CLICK_PX = 4;

// A wheel tells pixels, lines or pages; a pinch on a touch pad comes as a wheel with ctrlKey.
export function wheelFactor({ deltaY, deltaMode, ctrlKey }: Pick<WheelEvent, 'deltaY' | 'deltaMode' | 'ctrlKey'>): number {
  const pixels = deltaY * (deltaMode === 1 ? LINE_PX : deltaMode === 2 ? PAGE_PX : 1);
  return Math.exp(-Math.min(400, Math.max(-400, pixels)) * (ctrlKey ? 0.01 : 0.0016));
}

// Pointer, wheel, touch and keys of the canvas. Returns what ends it.
export function listen(canvas: HTMLElement, target: InputTarget): () => void {
  const down = new Map<number, Point>();
  const { pen } = target;
  let drawing: number | undefined;
  let travelled = 0;
  const at = (event: MouseEvent): Point => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const spread = () => {
    const [a, b] = [...down.values()];
    return a && b ? { middle: { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 }, length: Math.hypot(a.x - b.x, a.y - b.y) } : undefined;
  };

  const onDown = (event: PointerEvent) => {
    if (event.button !== 0 && !(pen && event.button === 1)) return;
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, at(event));
    travelled = 0;
    if (drawing !== undefined) {
      drawing = undefined;
      pen?.cancel();
    } else if (down.size === 1 && pen?.begin(at(event), event)) {
      drawing = event.pointerId;
    }
  };
  const onMove = (event: PointerEvent) => {
    const now = at(event);
    const before = down.get(event.pointerId);
    if (!before) return target.hover(now);
    if (drawing === event.pointerId) {
      down.set(event.pointerId, now);
      const passed = event.getCoalescedEvents?.().map(at) ?? []; // missing on plain http
      return pen?.move(passed.length > 0 ? passed : [now]);
    }
    const pinch = spread();
    down.set(event.pointerId, now);
    travelled += Math.hypot(now.x - before.x, now.y - before.y);
    const pinched = spread();
    if (pinch && pinched && pinch.length > 0) {
      target.pan(pinched.middle.x - pinch.middle.x, pinched.middle.y - pinch.middle.y);
      target.zoom(pinched.middle, pinched.length / pinch.length);
    } else if (travelled > CLICK_PX) {
      target.pan(now.x - before.x, now.y - before.y);
    }
  };
  const onUp = (event: PointerEvent) => {
    const known = down.delete(event.pointerId);
    if (drawing === event.pointerId) {
      drawing = undefined;
      return event.type === 'pointerup' ? pen?.end(at(event)) : pen?.cancel();
    }
    if (known && down.size === 0 && travelled <= CLICK_PX && event.type === 'pointerup') target.click(at(event));
  };
  const onWheel = (event: WheelEvent) => {
    event.preventDefault();
    target.zoom(at(event), wheelFactor(event));
  };
  const onLeave = () => target.hover(undefined);
  const onDouble = (event: MouseEvent) => target.open(at(event));
  const onMenu = (event: MouseEvent) => {
    if (target.menu(at(event))) event.preventDefault();
  };
  const onKey = (event: KeyboardEvent) => {
    if (!event.ctrlKey && !event.metaKey && !event.altKey && target.key(event.key)) event.preventDefault();
  };

  canvas.addEventListener('pointerdown', onDown);
  canvas.addEventListener('pointermove', onMove);
  canvas.addEventListener('pointerup', onUp);
  canvas.addEventListener('pointercancel', onUp);
  canvas.addEventListener('pointerleave', onLeave);
  canvas.addEventListener('wheel', onWheel, { passive: false });
  canvas.addEventListener('dblclick', onDouble);
  canvas.addEventListener('contextmenu', onMenu);
  canvas.addEventListener('keydown', onKey);
  return () => {
    canvas.removeEventListener('pointerdown', onDown);
    canvas.removeEventListener('pointermove', onMove);
    canvas.removeEventListener('pointerup', onUp);
    canvas.removeEventListener('pointercancel', onUp);
    canvas.removeEventListener('pointerleave', onLeave);
    canvas.removeEventListener('wheel', onWheel);
    canvas.removeEventListener('dblclick', onDouble);
    canvas.removeEventListener('contextmenu', onMenu);
    canvas.removeEventListener('keydown', onKey);
  };
}

// SPDX-License-Identifier: Apache-2.0
// What the pointer does with each tool.
import { inMiddle, brushEdits, fillEdit, lineEdits, polygonEdit, rectangleOf, type Style } from '../shapes';
import { cellOf, type Units } from '../lattice';
import { crossingOf } from '../raster/polygon';
import type { EditSession } from '../session';
import { radiusOf, type Settings, type ToolName } from './settings';
import { Stroke } from './stroke';

// What is being drawn and not an edit yet.
export interface Sketch {
  points: Units[];
  isClosed: boolean;
}

export interface Pen {
  begin(at: Units): void;
  move(at: Units[]): void;
  // Returns why nothing has become of it.
  end(at: Units): string | undefined;
  cancel(): void;
  sketch(): Sketch | undefined;
}

export interface PenContext {
  session: EditSession;
  settings: () => Settings;
  style: () => Style;
  // A ring for an area.
  area: (ring: Units[]) => void;
}

class BrushPen implements Pen {
  private stroke: Stroke | undefined;

  constructor(private readonly context: PenContext) {}

  begin(at: Units) {
    const { session, settings, style } = this.context;
    this.stroke = new Stroke(session, settings(), style());
    this.stroke.to(at);
  }
  move(at: Units[]) {
    for (const point of at) this.stroke?.to(point);
  }
  end(at: Units) {
    const { stroke } = this;
    this.stroke = undefined;
    stroke?.to(at);
    return stroke?.end();
  }
  cancel() {
    this.stroke?.cancel();
    this.stroke = undefined;
  }
  sketch() {
    return undefined;
  }
}

// From where the pointer goes down to where it comes up.
class DragPen implements Pen {
  private from: Units | undefined;
  private to: Units | undefined;

  constructor(private readonly context: PenContext, private readonly isRectangle: boolean) {}

  begin(at: Units) {
    this.from = this.to = at;
  }
  move(at: Units[]) {
    this.to = at.at(-1) ?? this.to;
  }
  end(at: Units) {
    const { from } = this;
    this.cancel();
    if (!from) return undefined;
    const { session, settings, style } = this.context;
    if (this.isRectangle) return session.add([polygonEdit(style(), rectangleOf(from, at))]);
    const points = [inMiddle(from), inMiddle(at)];
    return session.add(settings().size === 1 ? lineEdits(style(), points) : brushEdits(style(), points, radiusOf(settings())));
  }
  cancel() {
    this.from = this.to = undefined;
  }
  sketch() {
    const { from, to } = this;
    if (!from || !to) return undefined;
    return this.isRectangle ? { points: rectangleOf(from, to), isClosed: true } : { points: [inMiddle(from), inMiddle(to)], isClosed: false };
  }
}

// Corner by corner; it is closed at the first corner, by a double click or by Enter.
export class CornerPen implements Pen {
  private corners: Units[] = [];
  private at: Units | undefined;

  // `near`: how close two places are on the screen, in units.
  constructor(private readonly context: PenContext, private readonly near: () => number, private readonly isArea: boolean) {}

  begin(at: Units) {
    this.at = at;
  }
  move(at: Units[]) {
    this.at = at.at(-1);
  }
  hover(at: Units | undefined) {
    this.at = at;
  }
  end(at: Units) {
    const [first] = this.corners;
    const last = this.corners.at(-1);
    const isNear = (other: Units | undefined) => other !== undefined && Math.hypot(other.x - at.x, other.y - at.y) <= this.near();
    if (this.corners.length >= 3 && isNear(first)) return this.close();
    if (!isNear(last)) this.corners.push(at);
    return undefined;
  }
  close(): string | undefined {
    const ring = this.corners;
    if (ring.length < 3) return ring.length === 0 ? undefined : 'A polygon has at least three corners: click on more places.';
    const crossing = crossingOf(ring);
    if (crossing) return `Sides ${crossing[0] + 1} and ${crossing[1] + 1} cross: take corners back with Backspace.`;
    this.cancel();
    if (this.isArea) {
      this.context.area(ring);
      return undefined;
    }
    return this.context.session.add([polygonEdit(this.context.style(), ring)]);
  }
  back() {
    this.corners.pop();
  }
  cancel() {
    this.corners = [];
  }
  sketch() {
    if (this.corners.length === 0) return undefined;
    return { points: this.at ? [...this.corners, this.at] : this.corners, isClosed: this.corners.length > 1 };
  }
}

class FillPen implements Pen {
  constructor(private readonly context: PenContext) {}

  begin() {}
  move() {}
  end(at: Units) {
    const { session, style } = this.context;
    const { box } = session;
    const [column, row] = [cellOf(at.x), cellOf(at.y)];
    const isInside = box && column >= box.firstColumn && row >= box.firstRow && column < box.firstColumn + box.width && row < box.firstRow + box.height;
    if (!box || !isInside) return 'There is no map at this place: a fill begins in a cell of the map.';
    return session.add([fillEdit(style(), at, box)]);
  }
  cancel() {}
  sketch() {
    return undefined;
  }
}

export function pensOf(context: PenContext, near: () => number): Record<ToolName, Pen> {
  return {
    brush: new BrushPen(context), line: new DragPen(context, false), rectangle: new DragPen(context, true),
    polygon: new CornerPen(context, near, false), fill: new FillPen(context), area: new CornerPen(context, near, true),
  };
}

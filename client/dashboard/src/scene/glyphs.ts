// SPDX-License-Identifier: Apache-2.0
import { LinkPoint_Kind, LinkPoint_State, LinkPoint_Use } from '../gen/enfilade/v1/link_point_pb';
import type { GraphLinkPoint } from '../gen/enfilade/v1/graph_pb';
import type { Pose } from './camera';
import { ellipse95 } from './ellipse';
import { addGlyph, shape } from './gl/glyphLayer';
import type { InstanceList } from './gl/program';
import type { Frame } from './model';
import { rgba, type Palette, type Rgb } from './palette';

// Icons have a size in the world, so that they show scale, and one in pixels that they never fall below.
const ROBOT_M = 0.35;
const ROBOT_PX = 11;
const LINK_M = 0.3;
const LINK_PX = 7;
// A pose fades from 10 s to 10 min.
const FRESH_S = 10;
const OLD_S = 600;

const kindShape: Record<LinkPoint_Kind, number> = {
  [LinkPoint_Kind.UNSPECIFIED]: shape.diamond,
  [LinkPoint_Kind.DOOR]: shape.diamond,
  [LinkPoint_Kind.LIFT]: shape.square,
  [LinkPoint_Kind.STAIRS]: shape.triangle,
  [LinkPoint_Kind.RAMP]: shape.triangle,
  [LinkPoint_Kind.OPENING]: shape.disc,
};

interface Look {
  colour: Rgb;
  // Filled where it joins maps.
  filled: boolean;
  dash: number;
}

export function lookOf(point: GraphLinkPoint, { colour }: Palette): Look {
  if (point.use === LinkPoint_Use.SUSPENDED) return { colour: colour.off, filled: false, dash: 2.5 };
  if (point.use === LinkPoint_Use.SWITCHED_OFF) return { colour: colour.blocked, filled: false, dash: 2.5 };
  if (point.maps.length < 2) return { colour: colour.candidate, filled: false, dash: 0 };
  if (point.state === LinkPoint_State.BLOCKED) return { colour: colour.blocked, filled: true, dash: 0 };
  if (point.state === LinkPoint_State.CLOSED) return { colour: colour.candidate, filled: true, dash: 0 };
  return { colour: colour.link, filled: true, dash: 0 };
}

// Where the frame places a point of the world, from the middle of the window.
const across = ({ camera }: Frame, x: number) => (x - camera.x) * camera.scale;
const up = ({ camera }: Frame, y: number) => (y - camera.y) * camera.scale;

export function addLinkPoint(list: InstanceList, frame: Frame, palette: Palette, point: GraphLinkPoint, x: number, y: number, ghost: boolean) {
  const [px, py] = [across(frame, x), up(frame, y)];
  const half = Math.max(LINK_PX, LINK_M * frame.camera.scale);
  const { colour, filled, dash } = lookOf(point, palette);
  const fade = ghost ? 0.3 : 1;
  if (frame.view.selected === point.linkPoint) addSelection(list, palette, px, py, half + 6);
  const kind = point.maps.length < 2 ? shape.disc : kindShape[point.kind];
  addGlyph(list, {
    x: px, y: py, halfX: half, halfY: half, angle: 0, shape: kind, stroke: 4, dash: 0, line: rgba(palette.colour.halo, 0.9 * fade), fill: rgba(palette.colour.halo, 0.9 * fade),
  });
  addGlyph(list, {
    x: px, y: py, halfX: half, halfY: half, angle: 0, shape: kind, stroke: 2, dash, line: rgba(colour, fade), fill: rgba(colour, filled ? fade : 0),
  });
  const [x0, y0] = [frame.size.width / 2 + px, frame.size.height / 2 - py];
  frame.drawn.push({ name: point.linkPoint, kind: 'link', x: x0, y: y0, halfX: half, halfY: half, angle: 0, ghost, label: { x: x0, y: y0 + half + 11 } });
}

export function addSelection(list: InstanceList, palette: Palette, x: number, y: number, radius: number) {
  addGlyph(list, { x, y, halfX: radius, halfY: radius, angle: 0, shape: shape.disc, stroke: 2, dash: 0, line: rgba(palette.colour.select), fill: rgba(palette.colour.select, 0.15) });
}

// The covariance has the axes of the world, if the robot is placed there. On a map's own page those of the map are drawn.
export function turnOf({ site: { robots }, view }: Frame, row: number): number {
  if (view.map === undefined || !robots.placed[row]) return 0;
  return robots.map[3 * row + 2]! - robots.world[3 * row + 2]!;
}

// `age` in seconds. The heading is the arrow's; the ellipse contains the robot with 95 %.
export function addRobot(list: InstanceList, frame: Frame, palette: Palette, row: number, { x, y, yaw }: Pose, age: number, ghost: boolean) {
  const { robots } = frame.site;
  const name = robots.names[row]!;
  const [px, py] = [across(frame, x), up(frame, y)];
  const stale = age > FRESH_S;
  const fade = (ghost ? 0.3 : 1) * (stale ? 1 - 0.45 * Math.min(1, (age - FRESH_S) / (OLD_S - FRESH_S)) : 1);
  const colour = stale ? palette.colour.stale : palette.colour.robot;
  const half = Math.max(ROBOT_PX, ROBOT_M * frame.camera.scale);
  const c = robots.covariance;
  const ellipse = ellipse95(c[4 * row]!, c[4 * row + 1]!, c[4 * row + 2]!);
  const { major, minor } = ellipse;
  const angle = ellipse.angle + turnOf(frame, row);
  if (major * frame.camera.scale > half) {
    addGlyph(list, {
      x: px, y: py, halfX: major * frame.camera.scale, halfY: Math.max(1, minor * frame.camera.scale), angle, shape: shape.ellipse, stroke: 1.5, dash: 0,
      line: rgba(colour, 0.8 * fade), fill: rgba(colour, 0.12 * fade),
    });
  }
  if (frame.view.selected === name) addSelection(list, palette, px, py, half + 6);
  addGlyph(list, {
    x: px, y: py, halfX: half, halfY: half, angle: yaw, shape: shape.robot, stroke: 4, dash: 0, line: rgba(palette.colour.halo, fade), fill: rgba(palette.colour.halo, fade),
  });
  addGlyph(list, {
    x: px, y: py, halfX: half, halfY: half, angle: yaw, shape: shape.robot, stroke: 1.5, dash: 0, line: rgba(colour, fade), fill: rgba(colour, stale ? 0 : fade),
  });
  const [x0, y0] = [frame.size.width / 2 + px, frame.size.height / 2 - py];
  frame.drawn.push({
    name, kind: 'robot', x: x0, y: y0, halfX: major * frame.camera.scale, halfY: minor * frame.camera.scale, angle, ghost,
    label: { x: x0, y: y0 + half + 11 },
  });
}

export function addLine(list: InstanceList, frame: Frame, from: { x: number; y: number }, to: { x: number; y: number }, width: number, colour: number) {
  const [x0, y0, x1, y1] = [across(frame, from.x), up(frame, from.y), across(frame, to.x), up(frame, to.y)];
  addGlyph(list, {
    x: (x0 + x1) / 2, y: (y0 + y1) / 2, halfX: Math.hypot(x1 - x0, y1 - y0) / 2, halfY: width / 2, angle: Math.atan2(y1 - y0, x1 - x0),
    shape: shape.line, stroke: 0, dash: 0, line: 0, fill: colour,
  });
}

export function addCircle(list: InstanceList, frame: Frame, at: { x: number; y: number }, radius: number, colour: Rgb) {
  const half = radius * frame.camera.scale;
  addGlyph(list, { x: across(frame, at.x), y: up(frame, at.y), halfX: half, halfY: half, angle: 0, shape: shape.disc, stroke: 1, dash: 6, line: rgba(colour, 0.5), fill: 0 });
}

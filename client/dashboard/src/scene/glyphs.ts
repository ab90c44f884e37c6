// SPDX-License-Identifier: Apache-2.0
import { LinkPoint_Kind, LinkPoint_State, LinkPoint_Use } from '../gen/enfilade/v1/link_point_pb';
import type { GraphLinkPoint } from '../gen/enfilade/v1/graph_pb';
import type { Pose } from './camera';
import { ellipse95 } from './ellipse';
import { addGlyph, shape } from './gl/glyphLayer';
import type { InstanceList } from './gl/program';
import type { Drawn, Frame } from './model';
import { rgba, type Palette, type Rgb } from './palette';
import type { PlacedLink } from './placement';

// Icons have a size in the world, so that they show scale, and one in pixels that they never fall below. Where a room is
// no larger than an icon, that is smaller: icons would hide the maps.
const ROBOT_M = 0.35;
const ROBOT_PX = 11;
const LINK_M = 0.3;
const LINK_PX = 7;
// Pixels per metre at which icons begin to shrink, and by how much they do at most.
const ROOMY_SCALE = 6;
const SHRUNK = 0.4;

const halfOf = (metres: number, pixels: number, scale: number, isSelected: boolean) =>
  Math.max(pixels * (isSelected ? 1 : Math.min(1, Math.max(SHRUNK, scale / ROOMY_SCALE))), metres * scale);

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

// A link point's icon; colours packed by rgba().
export interface LinkGlyph {
  kind: number;
  halo: number;
  line: number;
  fill: number;
  dash: number;
}

export function glyphOf(point: GraphLinkPoint, palette: Palette, ghost: boolean): LinkGlyph {
  const { colour, filled, dash } = lookOf(point, palette);
  const fade = ghost ? 0.3 : 1;
  return {
    kind: point.maps.length < 2 ? shape.disc : kindShape[point.kind], halo: rgba(palette.colour.halo, 0.9 * fade), line: rgba(colour, fade),
    fill: rgba(colour, filled ? fade : 0), dash,
  };
}

// Where an icon is in the window, and its name below it.
function moveTo(drawn: Drawn, { size }: Frame, px: number, py: number, half: number) {
  drawn.x = drawn.label.x = size.width / 2 + px;
  drawn.y = size.height / 2 - py;
  drawn.label.y = drawn.y + half + 11;
}

export function addLinkPoint(list: InstanceList, frame: Frame, palette: Palette, { x, y, glyph, drawn }: PlacedLink) {
  const [px, py] = [across(frame, x), up(frame, y)];
  const half = halfOf(LINK_M, LINK_PX, frame.camera.scale, frame.view.selected === drawn.name);
  const { kind, halo, line, fill, dash } = glyph;
  if (frame.view.selected === drawn.name) addSelection(list, palette, px, py, half + 6);
  addGlyph(list, { x: px, y: py, halfX: half, halfY: half, angle: 0, shape: kind, stroke: 4, dash: 0, line: halo, fill: halo });
  addGlyph(list, { x: px, y: py, halfX: half, halfY: half, angle: 0, shape: kind, stroke: 2, dash, line, fill });
  moveTo(drawn, frame, px, py, half);
  drawn.halfX = drawn.halfY = half;
  frame.drawn.push(drawn);
}

export function addSelection(list: InstanceList, palette: Palette, x: number, y: number, radius: number) {
  addGlyph(list, { x, y, halfX: radius, halfY: radius, angle: 0, shape: shape.disc, stroke: 2, dash: 0, line: rgba(palette.colour.select), fill: rgba(palette.colour.select, 0.15) });
}

// The covariance has the axes of the world, if the robot is placed there. On a map's own page those of the map are drawn.
export function turnOf({ site: { robots }, view }: Frame, row: number): number {
  if (view.map === undefined || !robots.placed[row]) return 0;
  return robots.map[3 * row + 2]! - robots.world[3 * row + 2]!;
}

// The colours of a robot, packed by rgba().
interface RobotLook {
  ellipse: number;
  inside: number;
  halo: number;
  line: number;
  fill: number;
}

function robotLook({ colour }: Palette, fade: number, stale: boolean): RobotLook {
  const own = stale ? colour.stale : colour.robot;
  return { ellipse: rgba(own, 0.8 * fade), inside: rgba(own, 0.12 * fade), halo: rgba(colour.halo, fade), line: rgba(own, fade), fill: rgba(own, stale ? 0 : fade) };
}

// Of most robots; that of an old one depends on its age.
export const robotLooks = (palette: Palette) => ({ fresh: robotLook(palette, 1, false), ghost: robotLook(palette, 0.3, false) });

// Of a robot that is looked at.
export const robotHalf = (scale: number) => halfOf(ROBOT_M, ROBOT_PX, scale, true);

// An arrow head at a place of the window, x and y from its middle.
export function addHeading(list: InstanceList, { x, y, yaw }: Pose, half: number, { halo, line, fill }: Pick<RobotLook, 'halo' | 'line' | 'fill'>) {
  addGlyph(list, { x, y, halfX: half, halfY: half, angle: yaw, shape: shape.robot, stroke: 4, dash: 0, line: halo, fill: halo });
  addGlyph(list, { x, y, halfX: half, halfY: half, angle: yaw, shape: shape.robot, stroke: 1.5, dash: 0, line, fill });
}

// `age` in seconds. The heading is the arrow's; the ellipse contains the robot with 95 %.
export function addRobot(list: InstanceList, frame: Frame, palette: Palette, looks: ReturnType<typeof robotLooks>, row: number, { x, y, yaw }: Pose, age: number, drawn: Drawn) {
  const { scale } = frame.camera;
  const [px, py] = [across(frame, x), up(frame, y)];
  const faded = (drawn.ghost ? 0.3 : 1) * (1 - 0.45 * Math.min(1, Math.max(0, (age - FRESH_S) / (OLD_S - FRESH_S))));
  const look = age > FRESH_S ? robotLook(palette, faded, true) : drawn.ghost ? looks.ghost : looks.fresh;
  const half = halfOf(ROBOT_M, ROBOT_PX, scale, frame.view.selected === drawn.name);
  const c = frame.site.robots.covariance;
  const { major, minor, angle } = ellipse95(c[4 * row]!, c[4 * row + 1]!, c[4 * row + 2]!);
  drawn.halfX = major * scale;
  drawn.halfY = minor * scale;
  drawn.angle = angle + turnOf(frame, row);
  if (drawn.halfX > half) {
    addGlyph(list, {
      x: px, y: py, halfX: drawn.halfX, halfY: Math.max(1, drawn.halfY), angle: drawn.angle, shape: shape.ellipse, stroke: 1.5, dash: 0, line: look.ellipse, fill: look.inside,
    });
  }
  if (frame.view.selected === drawn.name) addSelection(list, palette, px, py, half + 6);
  addHeading(list, { x: px, y: py, yaw }, half, look);
  moveTo(drawn, frame, px, py, half);
  frame.drawn.push(drawn);
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

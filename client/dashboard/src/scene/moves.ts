// SPDX-License-Identifier: Apache-2.0
// How maps have moved: arrows, and outlines of where they were.
import { affineOf, apply } from './affine';
import { worldToScreen, type Bounds, type Point, type Pose } from './camera';
import type { Sources } from './drawing';
import { addGlyph, shape } from './gl/glyphLayer';
import type { InstanceList } from './gl/program';
import { addLine } from './glyphs';
import type { Frame, MapMove } from './model';
import { thumbnailAffine } from './outlines';
import { rgba, type Palette } from './palette';
import type { Thumbnail } from './tiles/manifest';

const HEAD_PX = 7;
// Shorter arrows are a head without a shaft, whose direction tells nothing.
const SHOWN_PX = 2;

// In the world: the middle of a map's picture, or its frame if it has none.
export function middleAt(pose: Pose, thumbnail: Thumbnail | undefined): Point {
  if (!thumbnail) return pose;
  return apply(thumbnailAffine(affineOf(pose), thumbnail), { x: thumbnail.width / 2, y: thumbnail.height / 2 });
}

// A power of ten with which the longest way is at least a twentieth of the whole, so that it is seen; 1 to 1000.
export function stretchFor(longest: number, { minX, minY, maxX, maxY }: Bounds): number {
  if (!(longest > 0)) return 1;
  const wanted = Math.hypot(maxX - minX, maxY - minY) / 20;
  return 10 ** Math.min(3, Math.max(0, Math.ceil(Math.log10(wanted / longest))));
}

function addOutline(list: InstanceList, frame: Frame, palette: Palette, pose: Pose, thumbnail: Thumbnail) {
  const { camera, size } = frame;
  const cells = thumbnailAffine(affineOf(pose), thumbnail);
  const at = worldToScreen(camera, size, middleAt(pose, thumbnail));
  const scale = (thumbnail.resolution * camera.scale) / 2;
  addGlyph(list, {
    x: at.x - size.width / 2, y: size.height / 2 - at.y, halfX: thumbnail.width * scale, halfY: thumbnail.height * scale, angle: Math.atan2(cells.b, cells.a),
    shape: shape.frame, stroke: 1.5, dash: 4, line: rgba(palette.colour.stale), fill: 0,
  });
}

function addArrow(list: InstanceList, frame: Frame, from: Point, to: Point, colour: number, halo: number) {
  const { camera, size } = frame;
  const [a, b] = [worldToScreen(camera, size, from), worldToScreen(camera, size, to)];
  const length = Math.hypot(b.x - a.x, b.y - a.y);
  if (length < SHOWN_PX) return { a, b };
  const angle = Math.atan2(a.y - b.y, b.x - a.x);
  // The head ends where the arrow does; the shaft ends in it.
  const back = Math.min(HEAD_PX, length) / camera.scale;
  const end = { x: to.x - back * Math.cos(angle), y: to.y - back * Math.sin(angle) };
  const head = { x: b.x - HEAD_PX * Math.cos(angle) - size.width / 2, y: size.height / 2 - b.y - HEAD_PX * Math.sin(angle), halfX: HEAD_PX, halfY: HEAD_PX, angle, shape: shape.robot, dash: 0 };
  addLine(list, frame, from, end, 6, halo);
  addGlyph(list, { ...head, stroke: 4, line: halo, fill: halo });
  addLine(list, frame, from, end, 3, colour);
  addGlyph(list, { ...head, stroke: 0, line: 0, fill: colour });
  return { a, b };
}

function addMove(list: InstanceList, frame: Frame, palette: Palette, { map, from, to }: MapMove, stretch: number, thumbnail: Thumbnail | undefined) {
  const [was, is] = [middleAt(from, thumbnail), middleAt(to, thumbnail)];
  // It ends where the map is, so that the picture is true and only the arrow is not to scale.
  const begin = { x: is.x - stretch * (is.x - was.x), y: is.y - stretch * (is.y - was.y) };
  const { a, b } = addArrow(list, frame, begin, is, rgba(palette.colour.select), rgba(palette.colour.halo));
  frame.marks.push({ kind: 'move', name: map, from: a, to: b });
}

export function addMoves(list: InstanceList, palette: Palette, frame: Frame, { loader }: Sources) {
  const { moves = [], stretch = 1, level } = frame.view;
  const shown = moves.filter(({ map }) => level === undefined || frame.site.maps.get(map)?.level === level);
  for (const { map, from } of shown) {
    const thumbnail = loader.thumbnails.get(map);
    // Where ways are drawn longer, they are small: then frames lie on one another, and only the selected one is of use.
    if (thumbnail && (stretch === 1 || map === frame.view.selected)) addOutline(list, frame, palette, from, thumbnail);
  }
  for (const move of shown) addMove(list, frame, palette, move, stretch, loader.thumbnails.get(move.map));
}

// SPDX-License-Identifier: Apache-2.0
// From a site's state to quads and glyphs of one frame.
import { affineOf, boundsOf, composed, overlap, type Affine } from './affine';
import type { Bounds, Point, Pose } from './camera';
import { addCircle, addLine, addLinkPoint, addRobot, robotLooks } from './glyphs';
import { addGlyph, shape } from './gl/glyphLayer';
import type { InstanceList } from './gl/program';
import { style, type RasterLayer } from './gl/rasterLayer';
import type { Drawn, Frame, RasterChoice } from './model';
import type { Motion } from './motion';
import { thumbnailAffine, type Outline, type Outlines } from './outlines';
import { rgba, type Palette } from './palette';
import { newDrawn, type PlacedLink, type PlacedMap } from './placement';
import { chained } from './se2';
import { coverOf, latticeOf } from './tiles/cover';
import type { RasterLoader } from './tiles/loader';
import type { Manifest, Thumbnail } from './tiles/manifest';
import type { TilePages } from './tiles/pages';
import { TrailPainter } from './trail';

export interface Sources {
  loader: RasterLoader;
  tiles: TilePages;
  thumbnailPage: WebGLTexture | undefined;
  outlines: Outlines;
  // Counts frames.
  frame: number;
  deviceRatio: number;
}

// From the world to clip space, relative to the camera before it becomes float32.
function toClip({ camera, size }: Frame): Affine {
  const sx = (2 * camera.scale) / size.width;
  const sy = (2 * camera.scale) / size.height;
  return { a: sx, b: 0, c: 0, d: sy, e: -camera.x * sx, f: -camera.y * sy };
}

// Of a map's picture in the world; undefined if it has none yet.
export function mapBounds(worldMap: Affine, thumbnail: Thumbnail | undefined): Bounds | undefined {
  return thumbnail && boundsOf(thumbnailAffine(worldMap, thumbnail), 0, 0, thumbnail.width, thumbnail.height);
}

function styleOf(frame: Frame, map: string, ghost: boolean, choice: RasterChoice | undefined): number {
  if (choice && choice.role !== 'only') return choice.role === 'before' ? style.before : style.after;
  if (ghost) return style.ghost;
  return frame.view.selected === map && !frame.view.map ? style.selected : style.plain;
}

// What the maps of one frame are drawn with.
interface MapDrawing {
  layer: RasterLayer;
  frame: Frame;
  sources: Sources;
  // From the world to clip space.
  clip: Affine;
  missing: string[];
}

function addThumbnail({ layer, sources, clip }: MapDrawing, { cells, thumbnail }: Outline, look: number) {
  if (!sources.thumbnailPage || thumbnail.layer < 0) return;
  const { a, b, c, d, e, f } = composed(clip, cells);
  const { width, height } = thumbnail;
  layer.add(sources.thumbnailPage, { clip: { a: a * width, b: b * width, c: c * height, d: d * height, e, f }, u0: 0, v0: 0, u1: width, v1: height, layer: thumbnail.layer, style: look });
}

function addTiles({ layer, frame, sources, clip, missing }: MapDrawing, worldMap: Affine, manifest: Manifest, thumbnail: Thumbnail | undefined, look: number) {
  const cover = coverOf(manifest, thumbnail, worldMap, frame.window, frame.camera.scale * sources.deviceRatio, (key) => sources.tiles.has(key));
  const { a, b, c, d, e, f } = composed(clip, latticeOf(worldMap, manifest));
  for (const { x0, y0, x1, y1, key, u0, v0, u1, v1 } of cover.patches) {
    const slot = key === undefined ? undefined : sources.tiles.find(key, sources.frame);
    const page = slot?.page ?? sources.thumbnailPage;
    const index = slot?.layer ?? thumbnail?.layer ?? -1;
    if (!page || index < 0) continue;
    layer.add(page, {
      clip: { a: a * (x1 - x0), b: b * (x1 - x0), c: c * (y1 - y0), d: d * (y1 - y0), e: a * x0 + c * y0 + e, f: b * x0 + d * y0 + f },
      u0, v0, u1, v1, layer: index, style: look,
    });
  }
  missing.push(...cover.missing);
}

// Draws one revision. A thumbnail is enough as long as its cells are no larger than the device's pixels.
function addRevision(draw: MapDrawing, pose: Pose, outline: Outline | undefined, revision: string, look: number) {
  const { frame, sources } = draw;
  const thumbnail = outline?.thumbnail;
  if (!thumbnail && !sources.loader.hasOverview) return; // one request for all of them is under way
  if (outline && !overlap(outline.bounds, frame.window) && thumbnail?.revision === revision) return;
  const enough = thumbnail?.revision === revision && thumbnail.resolution * frame.camera.scale * sources.deviceRatio <= 1;
  const manifest = enough ? undefined : sources.loader.manifest(revision);
  if (manifest) addTiles(draw, affineOf(pose), manifest, thumbnail, look);
  else if (outline) addThumbnail(draw, outline, look);
}

function addMapBox(frame: Frame, glyphs: InstanceList, palette: Palette, drawn: Drawn, { middle, halfX, halfY, angle, label }: Outline) {
  const { camera, size, view } = frame;
  moveTo(drawn, frame, middle, label);
  drawn.halfX = halfX * camera.scale;
  drawn.halfY = halfY * camera.scale;
  drawn.angle = angle;
  frame.drawn.push(drawn);
  if (view.selected === drawn.name && view.map === undefined) {
    addGlyph(glyphs, {
      x: drawn.x - size.width / 2, y: size.height / 2 - drawn.y, halfX: drawn.halfX + 4, halfY: drawn.halfY + 4, angle, shape: shape.frame, stroke: 2, dash: 0,
      line: rgba(palette.colour.select), fill: 0,
    });
  }
}

function moveTo(drawn: Drawn, { camera, size }: Frame, middle: Point, label: Point) {
  drawn.x = size.width / 2 + (middle.x - camera.x) * camera.scale;
  drawn.y = size.height / 2 - (middle.y - camera.y) * camera.scale;
  drawn.label.x = size.width / 2 + (label.x - camera.x) * camera.scale;
  drawn.label.y = size.height / 2 - (label.y - camera.y) * camera.scale;
}

// Returns the tiles that the frame wants and that are not there.
export function addMaps(layer: RasterLayer, glyphs: InstanceList, palette: Palette, frame: Frame, sources: Sources, maps: PlacedMap[]): string[] {
  const draw: MapDrawing = { layer, frame, sources, clip: toClip(frame), missing: [] };
  for (const { pose, ghost, outline, revision, choices, drawn } of maps) {
    if (choices) for (const choice of choices) addRevision(draw, pose, outline, choice.revision, styleOf(frame, drawn.name, ghost, choice));
    else if (revision !== undefined) addRevision(draw, pose, outline, revision, styleOf(frame, drawn.name, ghost, undefined));
    if (outline) addMapBox(frame, glyphs, palette, drawn, outline);
  }
  return draw.missing;
}

const inside = (window: Bounds, x: number, y: number, margin: number) =>
  x > window.minX - margin && x < window.maxX + margin && y > window.minY - margin && y < window.maxY + margin;

export function addLinkPoints(glyphs: InstanceList, palette: Palette, frame: Frame, links: PlacedLink[]) {
  const margin = 20 / frame.camera.scale;
  for (const link of links) if (inside(frame.window, link.x, link.y, margin)) addLinkPoint(glyphs, frame, palette, link);
}

const poseIn = (table: ArrayLike<number>, row: number): Pose => ({ x: table[3 * row]!, y: table[3 * row + 1]!, yaw: table[3 * row + 2]! });

// Each robot of the table that is in the window, with its row and where it is on its way to its place.
function eachRobot({ site: { robots }, view, window, now }: Frame, motion: Motion, take: (row: number, at: Pose) => void) {
  const own = view.map !== undefined;
  const from = own ? robots.map : robots.world;
  for (let row = 0; row < robots.count; ++row) {
    if (own ? robots.maps[row] !== view.map : !robots.placed[row]) continue;
    const shifted = own ? undefined : view.shifted?.get(robots.maps[row]!);
    const to = shifted ? chained(shifted, poseIn(robots.map, row)) : poseIn(from, row);
    const at = motion.at(robots.names[row]!, to, now, view.still);
    if (inside(window, at.x, at.y, 20)) take(row, at);
  }
}

// Trails lie below all robots. `known`: of each row of the table what was drawn in the last frame, to be used again.
export function addRobots(glyphs: InstanceList, palette: Palette, frame: Frame, motion: Motion, places: ReadonlyMap<string, Pose>, known: Drawn[]) {
  const { site, view } = frame;
  if (view.places || view.path) return;
  const { robots } = site;
  const isGhost = (row: number) => view.map === undefined && view.level !== undefined && robots.level[row] !== view.level;
  if (view.trails) {
    const painter = new TrailPainter(glyphs, frame, places, palette);
    eachRobot(frame, motion, (row, at) => !isGhost(row) && painter.paint(robots.names[row]!, at));
  }
  const looks = robotLooks(palette);
  eachRobot(frame, motion, (row, at) => {
    const drawn = (known[row] ??= newDrawn('', 'robot', false));
    drawn.name = robots.names[row]!;
    drawn.ghost = isGhost(row);
    addRobot(glyphs, frame, palette, looks, row, at, site.ageOf(robots.receiveTime[row]!, frame.wall), drawn);
  });
}

export function addExplanation(glyphs: InstanceList, palette: Palette, frame: Frame, measured: { x: number; y: number }[]) {
  const { chain = [], searchRadius } = frame.view;
  const colour = rgba(palette.colour.select, 0.85);
  for (let i = 1; i < chain.length; ++i) addLine(glyphs, frame, chain[i - 1]!, chain[i]!, 2, colour);
  if (searchRadius) addCircle(glyphs, frame, searchRadius.at, searchRadius.radius, palette.colour.select);
  for (let i = 1; i < measured.length; ++i) addLine(glyphs, frame, measured[i - 1]!, measured[i]!, 2, rgba(palette.colour.candidate));
}

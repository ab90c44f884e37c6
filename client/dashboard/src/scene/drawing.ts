// SPDX-License-Identifier: Apache-2.0
// From a site's state to quads and glyphs of one frame.
import { levelsOf } from '../live/objects';
import { affineOf, boundsOf, composed, inverted, overlap, type Affine } from './affine';
import { worldToScreen, type Bounds, type Pose } from './camera';
import { addCircle, addLine, addLinkPoint, addRobot } from './glyphs';
import { addGlyph, shape } from './gl/glyphLayer';
import type { InstanceList } from './gl/program';
import { style, type RasterLayer } from './gl/rasterLayer';
import type { Frame, RasterChoice } from './model';
import type { Motion } from './motion';
import { thumbnailAffine, type Outline, type Outlines } from './outlines';
import { rgba, type Palette } from './palette';
import { coverOf, latticeOf } from './tiles/cover';
import type { RasterLoader } from './tiles/loader';
import type { Manifest, Thumbnail } from './tiles/manifest';
import type { TilePages } from './tiles/pages';

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

function addThumbnail(layer: RasterLayer, frame: Frame, sources: Sources, { cells, thumbnail }: Outline, look: number) {
  if (!sources.thumbnailPage || thumbnail.layer < 0) return;
  const { a, b, c, d, e, f } = composed(toClip(frame), cells);
  const { width, height } = thumbnail;
  layer.add(sources.thumbnailPage, { clip: { a: a * width, b: b * width, c: c * height, d: d * height, e, f }, u0: 0, v0: 0, u1: width, v1: height, layer: thumbnail.layer, style: look });
}

function addTiles(layer: RasterLayer, frame: Frame, sources: Sources, worldMap: Affine, manifest: Manifest, thumbnail: Thumbnail | undefined, look: number, missing: string[]) {
  const cover = coverOf(manifest, thumbnail, worldMap, frame.window, frame.camera.scale * sources.deviceRatio, (key) => sources.tiles.has(key));
  const clip = composed(toClip(frame), latticeOf(worldMap, manifest));
  for (const { x0, y0, x1, y1, key, u0, v0, u1, v1 } of cover.patches) {
    const slot = key === undefined ? undefined : sources.tiles.find(key, sources.frame);
    const page = slot?.page ?? sources.thumbnailPage;
    const index = slot?.layer ?? thumbnail?.layer ?? -1;
    if (!page || index < 0) continue;
    const { a, b, c, d } = clip;
    layer.add(page, {
      clip: { a: a * (x1 - x0), b: b * (x1 - x0), c: c * (y1 - y0), d: d * (y1 - y0), e: a * x0 + c * y0 + clip.e, f: b * x0 + d * y0 + clip.f },
      u0, v0, u1, v1, layer: index, style: look,
    });
  }
  missing.push(...cover.missing);
}

// Draws one revision. A thumbnail is enough as long as its cells are no larger than the device's pixels.
function addRevision(layer: RasterLayer, frame: Frame, sources: Sources, pose: Pose, outline: Outline | undefined, revision: string, look: number, missing: string[]) {
  const thumbnail = outline?.thumbnail;
  if (!thumbnail && !sources.loader.hasOverview) return; // one request for all of them is under way
  if (outline && !overlap(outline.bounds, frame.window) && thumbnail?.revision === revision) return;
  const enough = thumbnail?.revision === revision && thumbnail.resolution * frame.camera.scale * sources.deviceRatio <= 1;
  const manifest = enough ? undefined : sources.loader.manifest(revision);
  if (manifest) addTiles(layer, frame, sources, affineOf(pose), manifest, thumbnail, look, missing);
  else if (outline) addThumbnail(layer, frame, sources, outline, look);
}

// Where the maps are in this frame: by name, what the graph says or, on a map's own page, that one alone at the origin.
export function placesOf(frame: Frame, motion: Motion): Map<string, Pose> {
  const places = new Map<string, Pose>();
  if (frame.view.map !== undefined) return places.set(frame.view.map, { x: 0, y: 0, yaw: 0 });
  for (const map of frame.site.maps.values()) {
    const pose = map.poseWorldMap?.pose;
    if (pose) places.set(map.map, motion.at(map.map, pose, frame.now));
  }
  return places;
}

function addMapBox(frame: Frame, glyphs: InstanceList, palette: Palette, map: string, { middle, halfX, halfY, angle, label }: Outline, ghost: boolean) {
  const { camera, size } = frame;
  const at = worldToScreen(camera, size, middle);
  const [halfW, halfH] = [halfX * camera.scale, halfY * camera.scale];
  frame.drawn.push({ name: map, kind: 'map', x: at.x, y: at.y, halfX: halfW, halfY: halfH, angle, ghost, label: worldToScreen(camera, size, label) });
  if (frame.view.selected === map && frame.view.map === undefined) {
    addGlyph(glyphs, {
      x: at.x - size.width / 2, y: size.height / 2 - at.y, halfX: halfW + 4, halfY: halfH + 4, angle, shape: shape.frame, stroke: 2, dash: 0,
      line: rgba(palette.colour.select), fill: 0,
    });
  }
}

export function addMaps(layer: RasterLayer, glyphs: InstanceList, palette: Palette, frame: Frame, sources: Sources, places: Map<string, Pose>): string[] {
  const missing: string[] = [];
  const { site, view } = frame;
  for (const ghostly of [true, false]) {
    for (const [map, pose] of places) {
      const level = site.maps.get(map)?.level;
      const ghost = view.map === undefined && view.level !== undefined && level !== view.level;
      if (ghost !== ghostly) continue;
      const outline = sources.outlines.of(map, pose, sources.loader.thumbnails.get(map));
      const choices = view.rasters?.filter((choice) => choice.map === map);
      const revision = site.rasters.get(map)?.revision;
      if (choices?.length) for (const choice of choices) addRevision(layer, frame, sources, pose, outline, choice.revision, styleOf(frame, map, ghost, choice), missing);
      else if (revision !== undefined) addRevision(layer, frame, sources, pose, outline, revision, styleOf(frame, map, ghost, undefined), missing);
      if (outline) addMapBox(frame, glyphs, palette, map, outline, ghost);
    }
  }
  return missing;
}

const inside = (window: Bounds, x: number, y: number, margin: number) =>
  x > window.minX - margin && x < window.maxX + margin && y > window.minY - margin && y < window.maxY + margin;

export function addLinkPoints(glyphs: InstanceList, palette: Palette, frame: Frame, motion: Motion) {
  const { site, view } = frame;
  const only = view.map === undefined ? undefined : site.maps.get(view.map)?.poseWorldMap?.pose;
  const toMap = only && inverted(affineOf(only));
  const margin = 20 / frame.camera.scale;
  for (const point of site.linkPoints.values()) {
    const place = point.poseWorldPlace?.pose;
    if (!place) continue;
    if (view.map !== undefined) {
      if (!toMap || !point.maps.includes(view.map)) continue;
      addLinkPoint(glyphs, frame, palette, point, toMap.a * place.x + toMap.c * place.y + toMap.e, toMap.b * place.x + toMap.d * place.y + toMap.f, false);
      continue;
    }
    const at = motion.at(point.linkPoint, place, frame.now);
    if (!inside(frame.window, at.x, at.y, margin)) continue;
    const ghost = view.level !== undefined && !levelsOf(site, point).includes(view.level);
    addLinkPoint(glyphs, frame, palette, point, at.x, at.y, ghost);
  }
}

export function addRobots(glyphs: InstanceList, palette: Palette, frame: Frame, motion: Motion) {
  const { site, view } = frame;
  const { robots } = site;
  for (let row = 0; row < robots.count; ++row) {
    const own = view.map !== undefined;
    if (own ? robots.maps[row] !== view.map : !robots.placed[row]) continue;
    const from = own ? robots.map : robots.world;
    const pose = { x: from[3 * row]!, y: from[3 * row + 1]!, yaw: from[3 * row + 2]! };
    const at = motion.at(robots.names[row]!, pose, frame.now);
    if (!inside(frame.window, at.x, at.y, 20)) continue;
    const ghost = !own && view.level !== undefined && robots.level[row] !== view.level;
    addRobot(glyphs, frame, palette, row, at, site.ageOf(robots.receiveTime[row]!, frame.wall), ghost);
  }
}

export function addExplanation(glyphs: InstanceList, palette: Palette, frame: Frame, measured: { x: number; y: number }[]) {
  const { chain = [], searchRadius } = frame.view;
  const colour = rgba(palette.colour.select, 0.85);
  for (let i = 1; i < chain.length; ++i) addLine(glyphs, frame, chain[i - 1]!, chain[i]!, 2, colour);
  if (searchRadius) addCircle(glyphs, frame, searchRadius.at, searchRadius.radius, palette.colour.select);
  for (let i = 1; i < measured.length; ++i) addLine(glyphs, frame, measured[i - 1]!, measured[i]!, 2, rgba(palette.colour.candidate));
}

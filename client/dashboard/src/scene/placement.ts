// SPDX-License-Identifier: Apache-2.0
// What the graph places, as it is drawn: made anew only when the graph, a picture or the view has changed, or while something
// is on its way to a new place. Most frames move only the camera and the robots.
import { levelsOf } from '../live/objects';
import type { GraphLinkPoint } from '../gen/enfilade/v1/graph_pb';
import { affineOf, apply, inverted } from './affine';
import type { Pose } from './camera';
import type { Sources } from './drawing';
import { glyphOf, type LinkGlyph } from './glyphs';
import type { Drawn, Frame, ObjectKind, RasterChoice } from './model';
import { Motion } from './motion';
import type { Outline } from './outlines';
import type { Palette } from './palette';
import { eachPlace, shiftedPlace } from './places';

export interface PlacedMap {
  pose: Pose;
  // Of another level than the one that is shown.
  ghost: boolean;
  outline: Outline | undefined;
  revision: string | undefined;
  // To draw instead of the revision.
  choices: RasterChoice[] | undefined;
  drawn: Drawn;
}

export interface PlacedLink {
  x: number;
  y: number;
  ghost: boolean;
  glyph: LinkGlyph;
  drawn: Drawn;
}

export const newDrawn = (name: string, kind: ObjectKind, ghost: boolean): Drawn => ({
  name, kind, ghost, x: 0, y: 0, halfX: 0, halfY: 0, angle: 0, label: { x: 0, y: 0 },
});

export class Placement {
  // Ghosts first: they lie below the others.
  maps: PlacedMap[] = [];
  links: PlacedLink[] = [];
  // Where the maps are, on their way to their places.
  places = new Map<string, Pose>();
  private madeOf: unknown[] = [];
  private moved = false;
  private readonly motion = new Motion();

  update(frame: Frame, { loader, outlines }: Sources, palette: Palette) {
    const { site, view, now } = frame;
    const madeOf = [site, view, palette, loader, site.graphRevision, site.rasterRevision, loader.overviews];
    if (!this.moved && madeOf.every((part, i) => part === this.madeOf[i])) return;
    this.madeOf = madeOf;
    this.places = this.placesOf(frame);
    const maps = [...this.places].map(([map, pose]) => {
      const ghost = view.map === undefined && view.level !== undefined && site.maps.get(map)?.level !== view.level;
      const chosen = view.rasters?.filter((choice) => choice.map === map);
      return {
        pose, ghost, outline: outlines.of(map, pose, loader.thumbnails.get(map)), revision: site.rasters.get(map)?.revision,
        choices: chosen?.length ? chosen : undefined, drawn: newDrawn(map, 'map', ghost),
      };
    });
    this.maps = [...this.ghostsOf(frame, { loader, outlines }), ...maps.filter(({ ghost }) => ghost), ...maps.filter(({ ghost }) => !ghost)];
    this.links = this.linksOf(frame, palette);
    this.moved = this.motion.moving(now);
  }

  // Whether something is still on its way.
  moving(): boolean {
    return this.moved;
  }

  clear() {
    this.motion.clear();
    this.madeOf = [];
  }

  private placesOf({ site, view, now }: Frame): Map<string, Pose> {
    const places = new Map<string, Pose>();
    eachPlace(site, view, (map, pose) => places.set(map, view.map === undefined ? this.motion.at(map, pose, now, view.still) : pose));
    return places;
  }

  private ghostsOf({ site, view }: Frame, { loader, outlines }: Pick<Sources, 'loader' | 'outlines'>): PlacedMap[] {
    return (view.ghosts ?? []).map(({ map, pose }) => ({
      pose, ghost: true, outline: outlines.of(`${map} as it was`, pose, loader.thumbnails.get(map)), revision: site.rasters.get(map)?.revision, choices: undefined, drawn: newDrawn(map, 'map', true),
    }));
  }

  private linksOf({ site, view, now }: Frame, palette: Palette): PlacedLink[] {
    const links: PlacedLink[] = [];
    if (view.places) return links;
    const add = (point: GraphLinkPoint, { x, y }: { x: number; y: number }, ghost: boolean) =>
      links.push({ x, y, ghost, glyph: glyphOf(point, palette, ghost), drawn: newDrawn(point.linkPoint, 'link', ghost) });
    const own = view.map === undefined ? undefined : site.maps.get(view.map)?.poseWorldMap?.pose;
    for (const point of site.linkPoints.values()) {
      const place = point.poseWorldPlace?.pose;
      if (!place) continue;
      if (view.map === undefined) add(point, this.motion.at(point.linkPoint, shiftedPlace(site, view, point.maps, place), now, view.still), view.level !== undefined && !levelsOf(site, point).includes(view.level));
      else if (own && point.maps.includes(view.map)) add(point, apply(inverted(affineOf(own)), place), false);
    }
    return links;
  }
}

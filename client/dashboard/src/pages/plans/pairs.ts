// SPDX-License-Identifier: Apache-2.0
// Points that a person shows on the sheet and in a map.
import type { PriorAlignment } from '../../gen/enfilade/v1/prior_map_pb';
import type { Point } from '../../scene/camera';

// In the frame of a map.
export interface Place extends Point {
  map: string;
}

export interface Pair {
  sheet: Point;
  place: Place;
}

// A pair is complete once both of its points are shown, in either order; a point that is shown again replaces itself.
export interface Draft {
  pairs: Pair[];
  sheet?: Point | undefined;
  place?: Place | undefined;
}

export type Change = { sheet: Point } | { place: Place } | { remove: number };

export function changed(draft: Draft, change: Change): Draft {
  if ('remove' in change) return { ...draft, pairs: draft.pairs.filter((_, i) => i !== change.remove) };
  const { pairs, sheet, place } = { ...draft, ...change };
  return sheet && place ? { pairs: [...pairs, { sheet, place }] } : { pairs, sheet, place };
}

// Those by which it was aligned last. One that is shown in the world frame belongs to no map, and is left out.
export const shownBefore = (alignment: PriorAlignment | undefined): Pair[] =>
  (alignment?.pairs ?? [])
    .filter(({ map }) => map !== '')
    .map(({ sheetX, sheetY, map, xM, yM }) => ({ sheet: { x: sheetX, y: sheetY }, place: { map, x: xM, y: yM } }));

export const toMessages = (pairs: Pair[]) => pairs.map(({ sheet, place }) => ({ sheetX: sheet.x, sheetY: sheet.y, map: place.map, xM: place.x, yM: place.y }));

// m, how far each pair is off the place that fits all best: turned, shifted and scaled, straight or turned over (Umeyama).
// Of two pairs and fewer there is nothing to tell. `worlds`: the places in the world.
export function residualsOf(sheets: Point[], worlds: Point[]): number[] {
  const n = sheets.length;
  if (n < 3) return [];
  const mean = (points: Point[]) => ({ x: points.reduce((sum, { x }) => sum + x, 0) / n, y: points.reduce((sum, { y }) => sum + y, 0) / n });
  const [s0, w0] = [mean(sheets), mean(worlds)];
  const fits = [-1, 1].map((side) => {
    // As complex numbers: world = a * sheet, of the sheet whose y is turned by `side`.
    let [re, im, square] = [0, 0, 0];
    const turned = sheets.map(({ x, y }) => ({ x: x - s0.x, y: side * (y - s0.y) }));
    turned.forEach(({ x, y }, i) => {
      const [u, v] = [worlds[i]!.x - w0.x, worlds[i]!.y - w0.y];
      re += x * u + y * v;
      im += x * v - y * u;
      square += x * x + y * y;
    });
    const [a, b] = square > 0 ? [re / square, im / square] : [0, 0];
    return turned.map(({ x, y }, i) => Math.hypot(a * x - b * y - (worlds[i]!.x - w0.x), b * x + a * y - (worlds[i]!.y - w0.y)));
  });
  const sum = (all: number[]) => all.reduce((total, one) => total + one * one, 0);
  return sum(fits[0]!) <= sum(fits[1]!) ? fits[0]! : fits[1]!;
}

interface Picture {
  naturalWidth: number;
  naturalHeight: number;
}

// From the window to the sheet, whose origin is the centre of the top left pixel. `box`: where the picture is shown.
export const onSheet = ({ naturalWidth, naturalHeight }: Picture, box: { left: number; top: number; width: number; height: number }, { x, y }: Point): Point => ({
  x: ((x - box.left) / box.width) * naturalWidth - 0.5, y: ((y - box.top) / box.height) * naturalHeight - 0.5,
});

// From the sheet to per cent of the picture.
export const inPicture = ({ naturalWidth, naturalHeight }: Picture, { x, y }: Point): Point => ({
  x: (100 * (x + 0.5)) / naturalWidth, y: (100 * (y + 0.5)) / naturalHeight,
});

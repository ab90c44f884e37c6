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

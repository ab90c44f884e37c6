// SPDX-License-Identifier: Apache-2.0
import { useReducer } from 'react';
import type { Georeference } from '../../gen/enfilade/v1/graph_pb';

// A place in a map and on the globe, as it is entered.
export interface Control {
  map: string;
  x: number;
  y: number;
  latitude: number;
  longitude: number;
}

const isSame = (a: Control, b: Control) => a.map === b.map && a.x === b.x && a.y === b.y && a.latitude === b.latitude && a.longitude === b.longitude;

export const isSameList = (a: Control[], b: Control[]) => a.length === b.length && a.every((control, i) => isSame(control, b[i]!));

export const savedControls = (georeference: Georeference | null): Control[] =>
  (georeference?.controlPoints ?? []).map(({ map, x, y, latitude, longitude }) => ({ map, x, y, latitude, longitude }));

// What the server said of a control point, if it has it as it is here.
export const residualOf = (control: Control, georeference: Georeference | null): number | undefined =>
  georeference?.controlPoints.find((point) => isSame(control, point))?.residualM;

// Undefined: as saved. The earlier ones are for undoing.
interface State {
  points: Control[] | undefined;
  earlier: (Control[] | undefined)[];
}

export type Change = { set: Control[] } | 'undo' | 'forget';

export function changed({ points, earlier }: State, change: Change): State {
  if (change === 'forget') return { points: undefined, earlier: [] };
  if (change === 'undo') return earlier.length === 0 ? { points, earlier } : { points: earlier.at(-1), earlier: earlier.slice(0, -1) };
  return { points: change.set, earlier: [...earlier, points] };
}

// The control points that are being changed.
export function useDraft(georeference: Georeference | null) {
  const [{ points, earlier }, change] = useReducer(changed, { points: undefined, earlier: [] });
  const saved = savedControls(georeference);
  const shown = points ?? saved;
  return { points: shown, isChanged: !isSameList(shown, saved), canUndo: earlier.length > 0, change };
}

// "50.7744, 6.0786" as maps of others copy it.
export function parseLatLon(text: string): { latitude: number; longitude: number } | undefined {
  const [, latitude, longitude] = /^\s*(-?\d+(?:\.\d+)?)\s*[,;\s]\s*(-?\d+(?:\.\d+)?)\s*$/.exec(text) ?? [];
  return latitude === undefined ? undefined : { latitude: Number(latitude), longitude: Number(longitude) };
}

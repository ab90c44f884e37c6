// SPDX-License-Identifier: Apache-2.0
// What a preview of changes says, as it is drawn and as it is told.
import type { LinkPointResidual, PreviewGraphResponse } from '../gen/enfilade/v1/graph_service_pb';
import type { PoseWithCovariance } from '../gen/enfilade/v1/geometry_pb';
import type { Pose } from '../scene/camera';
import type { MapMove } from '../scene/model';
import { count, metres, turned } from '../ui/format';
import { wrapped } from '../scene/se2';

export interface Effects {
  graphVersion: bigint;
  // Where maps would be, that are elsewhere now or have no place.
  places: ReadonlyMap<string, Pose>;
  // Of those that have a place before and after; the farthest first.
  moves: readonly MapMove[];
  // Maps that would get a place, and that would lose it.
  joined: readonly string[];
  lost: readonly string[];
  chi2Before: number;
  chi2After: number;
  degreesOfFreedom: number;
  // Used now, and not afterwards; and the other way round.
  switchedOff: readonly LinkPointResidual[];
  switchedOn: readonly LinkPointResidual[];
  residuals: readonly LinkPointResidual[];
}

const poseOf = (pose: PoseWithCovariance | undefined): Pose | undefined => pose?.pose && { x: pose.pose.x, y: pose.pose.y, yaw: pose.pose.yaw };

// `isPlaced`: whether a map has a place now; a map that has none loses none.
export function effectsOf(response: PreviewGraphResponse, isPlaced: (map: string) => boolean): Effects {
  const { graphVersion, movedMaps, chi2Before, chi2After, degreesOfFreedom, residuals, disconnectedMaps } = response;
  const places = new Map<string, Pose>();
  const moves: MapMove[] = [];
  const joined: string[] = [];
  const lost = new Set(disconnectedMaps.filter(isPlaced));
  for (const { map, poseWorldMapBefore, poseWorldMapAfter } of movedMaps) {
    const [from, to] = [poseOf(poseWorldMapBefore), poseOf(poseWorldMapAfter)];
    if (to) places.set(map, to);
    if (from && to) moves.push({ map, from, to });
    else if (to) joined.push(map);
    else if (from) lost.add(map);
  }
  return {
    graphVersion, places, moves, joined, lost: [...lost], chi2Before, chi2After, degreesOfFreedom, residuals,
    switchedOff: residuals.filter((one) => one.switchedOffAfter && !one.switchedOffBefore),
    switchedOn: residuals.filter((one) => one.switchedOffBefore && !one.switchedOffAfter),
  };
}

export const wayOf = ({ from, to }: MapMove) => ({ distance: Math.hypot(to.x - from.x, to.y - from.y), turn: wrapped(to.yaw - from.yaw) });

export const lengthText = (value: number) => (value < 1 ? `${(100 * value).toFixed(1)} cm` : metres(value));

export const moveText = (move: MapMove) => {
  const { distance, turn } = wayOf(move);
  return `${lengthText(distance)}, ${turned(turn)}`;
};

// "chi-squared 41.0 > 16.3"
export const misfit = ({ chi2After, gate }: Pick<LinkPointResidual, 'chi2After' | 'gate'>) => `chi-squared ${chi2After.toFixed(1)} ${chi2After > gate ? '>' : '≤'} ${gate.toFixed(1)}`;

// What would happen, in words; the worst first. `titleOf`: what people call a map or link point.
export function sentencesOf(effects: Effects, titleOf: (name: string) => string): { tone: 'bad' | 'warn' | 'good'; text: string }[] {
  const { moves, joined, lost, switchedOff, switchedOn } = effects;
  const named = (maps: readonly string[]) => maps.slice(0, 5).map(titleOf).join(', ') + (maps.length > 5 ? ` and ${maps.length - 5} more` : '');
  const said: ReturnType<typeof sentencesOf> = [];
  for (const one of switchedOff) said.push({ tone: 'bad', text: `${titleOf(one.linkPoint)} is switched off: ${misfit(one)}` });
  if (lost.length > 0) said.push({ tone: 'bad', text: `No place in the world: ${named(lost)}` });
  for (const one of switchedOn) said.push({ tone: 'good', text: `${titleOf(one.linkPoint)} is used again: ${misfit(one)}` });
  if (joined.length > 0) said.push({ tone: 'good', text: `Placed now: ${named(joined)}` });
  if (moves.length > 0) said.push({ tone: 'warn', text: `${count(moves.length, 'map moves', 'maps move')}, ${titleOf(moves[0]!.map)} the farthest: ${moveText(moves[0]!)}` });
  if (said.length === 0) said.push({ tone: 'good', text: 'No map moves, and no link point is switched off.' });
  return said;
}

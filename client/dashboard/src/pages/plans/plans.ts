// SPDX-License-Identifier: Apache-2.0
// What is told of a floor plan, and what can be done with it.
import { PriorAlignment_Model, PriorMap_State, type PriorMap, type PriorMapElements } from '../../gen/enfilade/v1/prior_map_pb';
import type { Tone } from '../../ui/Badge';
import { count } from '../../ui/format';

export const stateOfPlan: Record<PriorMap_State, [Tone, string]> = {
  [PriorMap_State.UNSPECIFIED]: ['quiet', 'Unknown'],
  [PriorMap_State.NEW]: ['quiet', 'Not aligned'],
  [PriorMap_State.PROPOSED]: ['warn', 'Proposed: look whether it is right'],
  [PriorMap_State.ACTIVE]: ['good', 'Active'],
  [PriorMap_State.DIVERGED]: ['bad', 'Does not fit'],
  [PriorMap_State.SUSPENDED]: ['quiet', 'Suspended'],
};

export const modelName: Record<PriorAlignment_Model, string> = {
  [PriorAlignment_Model.UNSPECIFIED]: '–',
  [PriorAlignment_Model.RIGID]: 'Turned and shifted',
  [PriorAlignment_Model.SIMILARITY]: 'Turned, shifted and scaled',
  [PriorAlignment_Model.ANISOTROPIC]: 'Scaled otherwise along y than along x',
  [PriorAlignment_Model.AFFINE]: 'Scaled and sheared',
};

// "62 %", of a share.
export const share = (part: number | undefined) => (part === undefined || !Number.isFinite(part) ? '–' : `${Math.round(100 * part)} %`);

// "214 walls, 31 doors, 24 rooms".
export const elementsText = (elements: PriorMapElements | undefined) =>
  [count(elements?.walls ?? 0, 'wall'), count(elements?.doors ?? 0, 'door'), count(elements?.rooms ?? 0, 'room')].join(', ');

// What the server would refuse is not offered.
export const mayActivate = ({ state, alignment }: PriorMap) =>
  alignment !== undefined && (state === PriorMap_State.PROPOSED || state === PriorMap_State.SUSPENDED);

export const maySuspend = ({ state, alignment }: PriorMap) =>
  alignment !== undefined && (state === PriorMap_State.PROPOSED || state === PriorMap_State.ACTIVE);

// Whether an alignment holds: without, there is nothing to compare or to draw.
export const isAligned = ({ state, alignment }: PriorMap) =>
  alignment !== undefined && state !== PriorMap_State.NEW && state !== PriorMap_State.DIVERGED;

export interface Answer {
  isAccepted: boolean;
  text: string;
}

// What an alignment came to. `residuals`: m, of the pairs that people showed.
export function answerOf({ state, reason }: PriorMap, residuals: number[] = []): Answer {
  const isAccepted = state === PriorMap_State.PROPOSED || state === PriorMap_State.ACTIVE;
  const worst = residuals.length === 0 ? '' : ` The pair that fits worst is off by ${Math.max(...residuals).toFixed(2)} m.`;
  return { isAccepted, text: `${isAccepted ? 'Accepted' : 'Not accepted'}${reason === '' ? '.' : `: ${reason}`}${worst}` };
}

const picture = /\.(png|jpe?g)$/i;

// Whether browsers show the sheet as the server reads it.
export const isPicture = ({ fileName }: PriorMap) => picture.test(fileName);

export const fileOf = (plan: string, file: string, product: string) => `/v1/${plan}/files/${encodeURIComponent(file)}?product=${product}`;

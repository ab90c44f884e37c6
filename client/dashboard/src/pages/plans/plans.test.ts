// SPDX-License-Identifier: Apache-2.0
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { PriorMap_State, PriorMapElementsSchema, PriorMapSchema } from '../../gen/enfilade/v1/prior_map_pb';
import { isPlaced } from '../../live/plans';
import { shownPlans } from '../campus/planWalls';
import { answerOf, elementsText, fileOf, isAligned, isPicture, mayActivate, maySuspend, share, stateOfPlan } from './plans';

const plan = (init: MessageInitShape<typeof PriorMapSchema>) => create(PriorMapSchema, init);
const aligned = { explained: 0.6 };
const states = [PriorMap_State.NEW, PriorMap_State.PROPOSED, PriorMap_State.ACTIVE, PriorMap_State.DIVERGED, PriorMap_State.SUSPENDED];

test('offers only what the server allows in a state', () => {
  expect(states.filter((state) => mayActivate(plan({ state, alignment: aligned })))).toEqual([PriorMap_State.PROPOSED, PriorMap_State.SUSPENDED]);
  expect(states.filter((state) => maySuspend(plan({ state, alignment: aligned })))).toEqual([PriorMap_State.PROPOSED, PriorMap_State.ACTIVE]);
  expect(states.filter((state) => isAligned(plan({ state, alignment: aligned })))).toEqual([PriorMap_State.PROPOSED, PriorMap_State.ACTIVE, PriorMap_State.SUSPENDED]);
  for (const state of states) expect([mayActivate(plan({ state })), maySuspend(plan({ state }))], stateOfPlan[state][1]).toEqual([false, false]);
});

test('shows plans on the campus that are in use or proposed', () => {
  expect(states.filter((state) => isPlaced(plan({ state })))).toEqual([PriorMap_State.PROPOSED, PriorMap_State.ACTIVE]);
  const plans = [plan({ name: 'a', level: 0, state: PriorMap_State.ACTIVE }), plan({ name: 'b', level: 1, state: PriorMap_State.PROPOSED }), plan({ name: 'c', level: 1, state: PriorMap_State.SUSPENDED })];
  expect(shownPlans(plans, 1).map(({ name }) => name)).toEqual(['b']);
  expect(shownPlans(plans, undefined).map(({ name }) => name)).toEqual(['a', 'b']);
});

test('tells the answer to an alignment', () => {
  expect(answerOf(plan({ state: PriorMap_State.PROPOSED, reason: 'explains 62 % of the walls' }))).toEqual({ isAccepted: true, text: 'Accepted: explains 62 % of the walls' });
  expect(answerOf(plan({ state: PriorMap_State.ACTIVE }))).toEqual({ isAccepted: true, text: 'Accepted.' });
  expect(answerOf(plan({ state: PriorMap_State.DIVERGED, reason: 'another place fits as well' }))).toEqual({ isAccepted: false, text: 'Not accepted: another place fits as well' });
  expect(answerOf(plan({ state: PriorMap_State.PROPOSED }), [0.1, 0.428]).text).toBe('Accepted. The pair that fits worst is off by 0.43 m.');
});

test('tells shares and counts', () => {
  expect([share(0.617), share(0), share(undefined), share(NaN)]).toEqual(['62 %', '0 %', '–', '–']);
  expect(elementsText(create(PriorMapElementsSchema, { walls: 214, doors: 1, rooms: 0 }))).toBe('214 walls, 1 door, 0 rooms');
  expect(elementsText(undefined)).toBe('0 walls, 0 doors, 0 rooms');
});

test('knows the sheets that a browser shows, and where files are', () => {
  expect(['a.png', 'B.JPG', 'c.jpeg', 'd.pdf', 'e.svg', 'png'].map((fileName) => isPicture(plan({ fileName })))).toEqual([true, true, true, false, false, false]);
  expect(fileOf('sites/s/priorMaps/p', 'Plan 1.png', 'sheet')).toBe('/v1/sites/s/priorMaps/p/files/Plan%201.png?product=sheet');
});

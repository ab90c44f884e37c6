// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { PreviewGraphResponseSchema } from '../gen/enfilade/v1/graph_service_pb';
import { Latest } from './latest';
import { effectsOf, sentencesOf } from './preview';
import { linkPointName, mapName, titleOf } from './testing';

const at = (x: number, y = 0, yaw = 0) => ({ pose: { x, y, yaw }, covariance: [] });

const isPlaced = (map: string) => map !== mapName('never');

const response = create(PreviewGraphResponseSchema, {
  graphVersion: 7n, chi2Before: 3, chi2After: 4, degreesOfFreedom: 6, disconnectedMaps: [mapName('lone'), mapName('never')],
  movedMaps: [
    { map: mapName('b'), poseWorldMapBefore: at(1), poseWorldMapAfter: at(4, 4, 0.1) },
    { map: mapName('new'), poseWorldMapAfter: at(9) },
    { map: mapName('lone'), poseWorldMapBefore: at(2) },
  ],
  residuals: [
    { linkPoint: linkPointName('off'), chi2Before: 1, chi2After: 41, gate: 16.27, switchedOffAfter: true },
    { linkPoint: linkPointName('on'), chi2Before: 20, chi2After: 2, gate: 16.27, switchedOffBefore: true },
    { linkPoint: linkPointName('same'), chi2Before: 99, chi2After: 99, gate: 16.27, switchedOffBefore: true, switchedOffAfter: true },
  ],
});

test('draws what moves from where it is to where it would be, and what gets a place', () => {
  const effects = effectsOf(response, isPlaced);
  expect([...effects.places]).toEqual([[mapName('b'), { x: 4, y: 4, yaw: 0.1 }], [mapName('new'), { x: 9, y: 0, yaw: 0 }]]);
  expect(effects.moves).toEqual([{ map: mapName('b'), from: { x: 1, y: 0, yaw: 0 }, to: { x: 4, y: 4, yaw: 0.1 } }]);
  expect(effects.joined).toEqual([mapName('new')]);
  expect(effects.lost).toEqual([mapName('lone')]);
});

test('names what is switched off first, with its chi-squared and its gate', () => {
  expect(sentencesOf(effectsOf(response, isPlaced), titleOf).map(({ text }) => text)).toEqual([
    'off is switched off: chi-squared 41.0 > 16.3',
    'No place in the world: lone',
    'on is used again: chi-squared 2.0 ≤ 16.3',
    'Placed now: new',
    '1 map moves, b the farthest: 5.00 m, +5.73°',
  ]);
  expect(sentencesOf(effectsOf(create(PreviewGraphResponseSchema, {}), isPlaced), titleOf)).toEqual([{ tone: 'good', text: 'No map moves, and no link point is switched off.' }]);
});

const pause = () => new Promise((resolve) => setTimeout(resolve, 5));

test('asks one question at a time, and the newest next', async () => {
  const asked: number[] = [];
  const told: number[] = [];
  const answers: (() => void)[] = [];
  const latest = new Latest<number, number>(
    (question) => new Promise((resolve) => {
      asked.push(question);
      answers.push(() => resolve(10 * question));
    }),
    (_, answer) => told.push(answer!),
    0,
  );
  for (const question of [1, 2, 3, 4]) latest.want(question);
  expect(asked).toEqual([1]);
  answers[0]!();
  await pause();
  expect(told).toEqual([10]);
  expect(asked).toEqual([1, 4]);
  answers[1]!();
  await pause();
  expect(told).toEqual([10, 40]);
});

test('tells nothing of what was withdrawn, and tells errors', async () => {
  const told: unknown[] = [];
  let fail: (error: Error) => void = () => {};
  const latest = new Latest<number, number>(() => new Promise((_, reject) => (fail = reject)), (question, _, error) => told.push([question, (error as Error).message]), 0);
  latest.want(1);
  latest.withdraw();
  fail(new Error('first'));
  await pause();
  latest.want(2);
  await pause();
  fail(new Error('second'));
  await pause();
  expect(told).toEqual([[2, 'second']]);
});

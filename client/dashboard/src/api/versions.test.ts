// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { readOwnWrites } from './versions';

// A gateway that tells `version` with each answer, and keeps what it was asked for.
function recorded(version: () => string | undefined) {
  const asked: (string | null)[] = [];
  let time = 0;
  const fetcher = readOwnWrites(
    async (_url, init) => {
      asked.push(new Headers(init.headers).get('Enfilade-Min-Graph-Version'));
      const told = version();
      return new Response('{}', { headers: told === undefined ? {} : { 'Enfilade-Graph-Version': told } });
    },
    () => time,
  );
  return { asked, fetcher, pass: (ms: number) => (time += ms) };
}

test('asks for the version of the last change of the same site', async () => {
  const told = ['sites/a=7', undefined, 'sites/a=8', undefined, undefined];
  const { asked, fetcher } = recorded(() => told.shift());
  await fetcher('/v1/sites/a:optimize', { method: 'POST' });
  await fetcher('/v1/sites/a/graph', {});
  await fetcher('/v1/sites/a/maps', { method: 'POST' });
  await fetcher('/v1/sites/a', {});
  await fetcher('/v1/sites/ab/graph', {});
  expect(asked).toEqual([null, 'sites/a=7', 'sites/a=7', 'sites/a=8', null]);
});

test('forgets a change after a minute', async () => {
  const told = ['sites/a=7', undefined];
  const { asked, fetcher, pass } = recorded(() => told.shift());
  await fetcher('/v1/sites/a:optimize', { method: 'POST' });
  pass(60_000);
  await fetcher('/v1/sites/a/graph', {});
  expect(asked).toEqual([null, null]);
});

// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { changed, parseLatLon } from './draft';

const point = { map: 'sites/s/maps/m', x: 1, y: 2, latitude: 50, longitude: 6 };

test('undoes change by change, down to what is saved', () => {
  const one = changed({ points: undefined, earlier: [] }, { set: [point] });
  const none = changed(one, { set: [] });
  expect(changed(none, 'undo').points).toEqual([point]);
  expect(changed(changed(none, 'undo'), 'undo').points).toBeUndefined();
  expect(changed({ points: undefined, earlier: [] }, 'undo')).toEqual({ points: undefined, earlier: [] });
  expect(changed(none, 'forget')).toEqual({ points: undefined, earlier: [] });
});

test('reads latitude and longitude as other maps copy them', () => {
  expect(parseLatLon('50.77441, 6.0786')).toEqual({ latitude: 50.77441, longitude: 6.0786 });
  expect(parseLatLon(' -33.9 -70.6 ')).toEqual({ latitude: -33.9, longitude: -70.6 });
  for (const text of ['50.7', '50.7,', 'N 50, E 6', '']) expect(parseLatLon(text)).toBeUndefined();
});

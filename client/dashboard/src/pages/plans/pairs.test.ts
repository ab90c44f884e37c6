// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { PriorAlignmentSchema } from '../../gen/enfilade/v1/prior_map_pb';
import { changed, inPicture, onSheet, residualsOf, shownBefore, toMessages, type Draft } from './pairs';

const place = (x: number) => ({ map: 'sites/s/maps/m', x, y: 1 });

test('a pair is complete once both points are shown, in either order', () => {
  let draft: Draft = { pairs: [] };
  draft = changed(draft, { sheet: { x: 1, y: 2 } });
  draft = changed(draft, { sheet: { x: 3, y: 4 } });
  expect(draft).toEqual({ pairs: [], sheet: { x: 3, y: 4 } });
  draft = changed(draft, { place: place(5) });
  expect(draft).toEqual({ pairs: [{ sheet: { x: 3, y: 4 }, place: place(5) }] });
  draft = changed(changed(draft, { place: place(6) }), { sheet: { x: 7, y: 8 } });
  expect(draft.pairs.map((pair) => pair.sheet.x)).toEqual([3, 7]);
  expect(changed(draft, { remove: 0 }).pairs.map((pair) => pair.sheet.x)).toEqual([7]);
});

test('removing a pair keeps a point that has no partner yet', () => {
  const draft = { pairs: [{ sheet: { x: 3, y: 4 }, place: place(5) }], sheet: { x: 1, y: 1 } };
  expect(changed(draft, { remove: 0 })).toEqual({ pairs: [], sheet: { x: 1, y: 1 } });
});

test('begins with the pairs of the last alignment, and sends them as they were', () => {
  const pairs = [{ sheetX: 1, sheetY: 2, map: 'sites/s/maps/m', xM: 3, yM: 4 }];
  const alignment = create(PriorAlignmentSchema, { pairs: [...pairs, { sheetX: 5, sheetY: 6, map: '', xM: 7, yM: 8 }] });
  expect(toMessages(shownBefore(alignment))).toEqual(pairs);
  expect(shownBefore(undefined)).toEqual([]);
});

test('tells at once how far pairs are off each other', () => {
  const sheets = [{ x: 0, y: 0 }, { x: 100, y: 0 }, { x: 100, y: 60 }, { x: 0, y: 60 }];
  const [c, s] = [0.05 * Math.cos(0.7), 0.05 * Math.sin(0.7)];
  for (const side of [-1, 1]) {
    const worlds = sheets.map(({ x, y }) => ({ x: c * x - s * side * y + 3, y: s * x + c * side * y - 4 }));
    for (const one of residualsOf(sheets, worlds)) expect(one).toBeCloseTo(0, 9);
    const wrong = worlds.map((p, i) => (i === 2 ? { x: p.x + 1, y: p.y } : p));
    const residuals = residualsOf(sheets, wrong);
    expect(residuals.indexOf(Math.max(...residuals))).toBe(2);
    expect(residuals[2]).toBeGreaterThan(0.2);
    expect(residuals[2]).toBeLessThan(1);
  }
  expect(residualsOf(sheets.slice(0, 2), sheets.slice(0, 2)), 'two always fit').toEqual([]);
  expect(residualsOf([sheets[0]!, sheets[0]!, sheets[0]!], sheets.slice(0, 3)).every(Number.isFinite)).toBe(true);
});

test('the origin of the sheet is the centre of the top left pixel', () => {
  const picture = { naturalWidth: 400, naturalHeight: 200 };
  const box = { left: 10, top: 20, width: 800, height: 400 }; // each pixel twice as large
  expect(onSheet(picture, box, { x: 11, y: 21 })).toEqual({ x: 0, y: 0 });
  expect(onSheet(picture, box, { x: 809, y: 419 })).toEqual({ x: 399, y: 199 });
  expect(inPicture(picture, { x: 199.5, y: -0.5 })).toEqual({ x: 50, y: 0 });
});

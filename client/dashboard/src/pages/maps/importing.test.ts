// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { lacking } from './importing';

const files = (...names: string[]) => names.map((name) => ({ name }));

test('takes a JSON file alone, or a YAML file with its image', () => {
  for (const names of [['m.json'], ['m.yaml', 'm.pgm'], ['M.YML', 'm.PNG']]) expect(lacking(files(...names))).toBeUndefined();
});

test('says what is missing', () => {
  expect(lacking([])).toMatch(/Choose/);
  expect(lacking(files('m.pgm'))).toMatch(/YAML file is missing/);
  expect(lacking(files('m.yaml'))).toMatch(/image is missing/);
  expect(lacking(files('m.json', 'm.yaml'))).toMatch(/alone/);
});

// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { fieldsOf, lacking } from './importing';

const what = (name: string | undefined, more: Partial<Record<'title' | 'level' | 'page' | 'layers' | 'metres', string> & { measure: { x: number; y: number }[] }> = {}) =>
  ({ file: name === undefined ? undefined : { name }, title: 'Floor 1', level: '1', page: '', layers: '', measure: [], metres: '', ...more });

test('takes the kinds of files that are plans', () => {
  for (const name of ['a.png', 'a.JPG', 'a.jpeg', 'a.pdf', 'a.svg', 'a.dxf', 'a.geojson', 'a.building.yaml']) expect(lacking(what(name)), name).toBeUndefined();
});

test('says what is missing or wrong', () => {
  expect(lacking(what(undefined))).toMatch(/Choose/);
  expect(lacking(what('a.docx'))).toMatch(/A plan is/);
  expect(lacking(what('a.png', { title: ' ' }))).toMatch(/name/);
  for (const level of ['', 'ground', '1.5']) expect(lacking(what('a.png', { level }))).toMatch(/level/);
  expect(lacking(what('a.png', { level: ' -2 ' }))).toBeUndefined();
  for (const page of ['0', 'x', '-1']) expect(lacking(what('a.pdf', { page }))).toMatch(/Pages/);
  expect(lacking(what('a.png', { page: 'x' }))).toBeUndefined();
});

test('sends a distance that is known, of pictures only', () => {
  const measure = [{ x: 1.5, y: 2 }, { x: 30, y: 2 }];
  expect(lacking(what('a.png', { measure: measure.slice(1), metres: '3' }))).toMatch(/second point/);
  for (const metres of ['', 'x', '0', '-1']) expect(lacking(what('a.png', { measure, metres }))).toMatch(/metres/);
  expect(lacking(what('a.png', { measure, metres: '7,25' }))).toBeUndefined();
  expect(fieldsOf(what('a.png', { measure, metres: '7,25' })).at(-1)).toEqual(['measure', '1.5,2,30,2=7.25']);
  expect(fieldsOf(what('a.pdf', { measure, metres: '7' }))).toHaveLength(2);
  expect(fieldsOf(what('a.png'))).toHaveLength(2);
});

test('sends pages of a PDF only, and layers of drawings only', () => {
  const all = { page: ' 2 ', layers: 'A-WALL*', title: ' Floor 1 ', level: ' -1 ' };
  const common = [['display_name', 'Floor 1'], ['level', '-1']];
  expect(fieldsOf(what('a.png', all))).toEqual(common);
  expect(fieldsOf(what('a.pdf', all))).toEqual([...common, ['page', '2']]);
  expect(fieldsOf(what('a.dxf', all))).toEqual([...common, ['layers', 'A-WALL*']]);
  expect(fieldsOf(what('a.pdf'))).toEqual([['display_name', 'Floor 1'], ['level', '1']]);
});

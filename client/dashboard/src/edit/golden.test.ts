// SPDX-License-Identifier: Apache-2.0
// The examples that the server is tested with, too (tests/data/edits): edits from an empty start, and the tiles they make.
import { readdirSync, readFileSync } from 'node:fs';
import { fromJson, type JsonValue } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { MapEditSchema } from '../gen/enfilade/v1/map_edit_pb';
import { editedOf } from './cells';
import { Draft } from './draft';

interface Example {
  edits: JsonValue[];
  tiles: { row: number; column: number; sha256: string; cells: number }[];
}

const folder = new URL('../../../../tests/data/edits/', import.meta.url);

test('edits make the same tiles as on the server', () => {
  const files = readdirSync(folder).filter((name) => name.endsWith('.json'));
  expect(files.length, 'tests/data/edits has examples').toBeGreaterThan(0);
  for (const file of files) {
    const { edits, tiles } = JSON.parse(readFileSync(new URL(file, folder), 'utf8')) as Example;
    const draft = new Draft();
    edits.map((json) => fromJson(MapEditSchema, json)).forEach((edit, i) => {
      draft.take([{ ...edit, editId: `${i}`, sequence: BigInt(i + 1), head: BigInt(i + 1), active: true }]);
    });
    for (const { row, column, sha256, cells } of tiles) {
      const where = `${file}, tile ${row}, ${column}`;
      expect(draft.overlay.tile(row, column).cells.filter((cell) => editedOf(cell) !== 0).length, where).toBe(cells);
      expect(draft.overlay.digest(row, column), where).toBe(sha256);
    }
    const known = new Set(tiles.map(({ row, column }) => `${row},${column}`));
    for (const { row, column, cells } of draft.overlay.tiles.values()) {
      if (!known.has(`${row},${column}`)) expect(cells.every((cell) => editedOf(cell) === 0), `${file} has no tile ${row}, ${column}`).toBe(true);
    }
  }
});

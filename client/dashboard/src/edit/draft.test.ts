// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { hex } from '../api/digests';
import type { MapEdit } from '../gen/enfilade/v1/map_edit_pb';
import { digestOf, type Value } from './cells';
import { Draft } from './draft';
import { History } from './history';
import { TILE } from './lattice';
import { Overlay } from './overlay';
import { random } from './random.testing';
import { DraftServer } from './server.testing';
import { brushEdits, lineEdits, polygonEdit, rectangleOf, type Style } from './shapes';

const styleOf = (author: string, value: number): Style => ({ author, value: value as Value, onlyWhere: [], invisible: false });

const TILES = [-1, 0, 1].flatMap((row) => [-1, 0, 1].map((column) => ({ row, column })));

// Of what edits say in nine tiles.
const digests = (overlay: Overlay) => TILES.map(({ row, column }) => overlay.digest(row, column));

function drawn(next: (low: number, high: number) => number, author: string): MapEdit {
  const point = () => ({ x: next(-60_000, 60_000), y: next(-60_000, 60_000) });
  const near = ({ x, y }: { x: number; y: number }) => ({ x: x + next(-20_000, 20_000), y: y + next(-20_000, 20_000) });
  const style = styleOf(author, next(1, 4));
  const from = point();
  const kind = next(0, 3);
  if (kind === 0) return brushEdits(style, [from, near(from), near(from)], next(0, 4000))[0]!;
  if (kind === 1) return lineEdits(style, [from, near(from)])[0]!;
  if (kind === 2) return polygonEdit(style, rectangleOf(from, near(from)));
  return polygonEdit(style, [from, near(from), near(from)]);
}

// A map with published edits under the draft.
function published(seed: number): Overlay {
  const overlay = new Overlay();
  const next = random(seed);
  for (const { row, column } of TILES) overlay.load(row, column, Uint8Array.from({ length: TILE * TILE }, () => next(0, 2) | (next(0, 3) << 4)));
  return overlay;
}

test('a thousand random edits, undone and redone at will, return to where they began', () => {
  const overlay = published(7);
  const draft = new Draft(overlay);
  const history = new History(draft.isActive);
  const start = digests(overlay);
  const seen = overlay.tile(0, 0).cells.slice();
  const next = random(8);
  for (let i = 0; i < 1000; ++i) {
    const what = next(0, 9);
    if (what < 6) {
      const edit = drawn(next, 'me');
      draft.draw(edit);
      history.add([edit.editId]);
    } else if (what < 9) draft.setActive(history.undo(), false);
    else draft.setActive(history.redo(), true);
  }
  expect(digests(overlay)).not.toEqual(start);
  while (history.canUndo) draft.setActive(history.undo(), false);
  expect(digests(overlay)).toEqual(start);
  expect(overlay.tile(0, 0).cells).toEqual(seen);
});

test('cells are those of the highest edit that is on, in whatever order the news come', () => {
  const server = new DraftServer();
  const next = random(9);
  const edits = Array.from({ length: 120 }, (_, i) => ({ ...drawn(next, 'me'), sequence: BigInt(i + 1), head: BigInt(i + 1), active: next(0, 3) > 0 }));
  server.edits.push(...edits);
  for (const seed of [1, 2, 3]) {
    const draft = new Draft();
    const shuffle = random(seed);
    const order = edits.map((edit) => ({ edit, at: shuffle(0, 1e6) })).sort((a, b) => a.at - b.at);
    for (const { edit } of order) {
      draft.take([{ ...edit, active: true }]);
      draft.take([{ ...edit, head: edit.head + 1000n }]);
      draft.take([{ ...edit, active: true }]); // an old piece of news
    }
    for (const { row, column } of TILES) expect(draft.overlay.digest(row, column), `${row}, ${column}`).toBe(hex(server.tile(row, column).sha256));
  }
});

test('what is on its way lies over what the server has, until it has its place in the order', () => {
  const draft = new Draft();
  const box = (value: number, author: string) => polygonEdit(styleOf(author, value), rectangleOf({ x: 0, y: 0 }, { x: 2560, y: 2560 }));
  const [mine, theirs] = [box(3, 'me'), box(2, 'other')];
  draft.draw(mine);
  draft.take([{ ...theirs, sequence: 2n, head: 2n, active: true }]);
  expect(draft.overlay.at(5, 5) >> 2).toBe(3);
  const alone = new Overlay();
  const other = new Draft(alone);
  other.take([{ ...theirs, sequence: 2n, head: 2n, active: true }]);
  expect(draft.storedDigest(0, 0)).toBe(alone.digest(0, 0));
  draft.take([{ ...mine, sequence: 1n, head: 1n, active: true }]);
  expect(draft.overlay.at(5, 5) >> 2).toBe(2);
  draft.setActive([theirs.editId], false);
  expect(draft.overlay.at(5, 5) >> 2).toBe(3);
  draft.settle([theirs.editId]); // refused
  expect(draft.overlay.at(5, 5) >> 2).toBe(2);
});

test('clearing takes published edits away', () => {
  const overlay = published(3);
  const draft = new Draft(overlay);
  draft.draw(polygonEdit(styleOf('me', 4), rectangleOf({ x: -70_000, y: -70_000 }, { x: 140_000, y: 140_000 })));
  expect(overlay.digest(0, 0)).toBe(digestOf(new Uint8Array(TILE * TILE)));
});

test('undo takes only the steps that are on, and what is drawn anew ends redo', () => {
  const on = new Set(['a', 'b', 'c']);
  const history = new History((id) => on.has(id));
  for (const step of [['a'], ['b', 'c']]) history.add(step);
  on.delete('c'); // by somebody else
  expect(history.undo()).toEqual(['b']);
  on.delete('b');
  expect(history.redo()).toEqual(['b', 'c']);
  on.add('b').add('c');
  on.clear();
  expect(history.canUndo).toBe(false);
  expect(history.undo()).toEqual([]);
});

test('after a reload the person’s own last steps can be undone and redone', () => {
  const draft = new Draft();
  const next = random(5);
  const edits = ['me', 'other', 'me', 'me', 'me'].map((author, i) => ({ ...drawn(next, author), editId: `e${i}`, sequence: BigInt(i + 1), head: BigInt(i + 1), active: i < 3 }));
  draft.take(edits);
  const history = new History(draft.isActive);
  history.remember(draft.entries.values(), 'me');
  expect(history.redo()).toEqual(['e3']);
  draft.setActive(['e3'], true);
  expect(history.redo()).toEqual(['e4']);
  draft.setActive(['e4'], true);
  const undone: string[] = [];
  for (let ids = history.undo(); ids.length > 0; ids = history.undo()) {
    undone.push(...ids);
    draft.setActive(ids, false);
  }
  expect(undone).toEqual(['e4', 'e3', 'e2', 'e0']);
});

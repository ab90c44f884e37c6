// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Draft } from '../draft';
import { random } from '../random.testing';
import { DraftServer } from '../server.testing';
import { polygonEdit, rectangleOf } from '../shapes';
import { MemoryStore, type Operation } from './operations';
import { Outbox } from './outbox';

const edit = (author = 'me', x = 0) => polygonEdit({ author, value: 3, onlyWhere: [], invisible: false }, rectangleOf({ x, y: 0 }, { x: x + 600, y: 600 }));

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

function made(server: DraftServer, store = new MemoryStore(), owner = 'page') {
  const draft = new Draft();
  const refused: [Operation, string][] = [];
  let ended: string | undefined;
  const outbox = new Outbox('sites/s/maps/m/drafts/d', owner, store, server.service, {
    answered: (answer) => draft.take(answer.edits),
    done: (operation) => operation.kind === 'setActive' && draft.settle(operation.ids),
    refused: (...what) => refused.push(what),
    knownHead: () => 0n,
    whyEnded: async () => ended,
  });
  return { draft, outbox, refused, store, end: (why: string) => (ended = why) };
}

const lost = () => {
  throw new ConnectError('the gateway cannot be reached', Code.Unavailable);
};

test('edits go in their order, those that wait together, and are forgotten when the server has them', async () => {
  const server = new DraftServer();
  const { outbox, store } = made(server);
  const edits = Array.from({ length: 250 }, (_, i) => edit('me', 600 * i));
  for (const each of edits) outbox.append(each);
  expect(await store.list('sites/s/maps/m/drafts/d')).toHaveLength(250);
  await vi.runAllTimersAsync();
  expect(server.edits.map(({ editId }) => editId)).toEqual(edits.map(({ editId }) => editId));
  expect(server.calls).toBe(3);
  expect(outbox.pending).toBe(0);
  expect(await store.list('sites/s/maps/m/drafts/d')).toEqual([]);
});

test('whatever is lost on the way there or back, the server has each edit once and each switch as it was last', async () => {
  const server = new DraftServer();
  const { outbox, refused } = made(server);
  const next = random(11);
  server.before = () => next(0, 2) === 0 && lost();
  server.after = () => next(0, 2) === 0 && lost();
  const ids: string[] = [];
  const active = new Map<string, boolean>();
  for (let i = 0; i < 200; ++i) {
    if (next(0, 2) > 0 || ids.length === 0) {
      const each = edit();
      ids.push(each.editId);
      active.set(each.editId, true);
      outbox.append(each);
    } else {
      const id = ids[next(0, ids.length - 1)]!;
      active.set(id, !active.get(id));
      outbox.setActive([id], active.get(id)!, 'me');
    }
    await vi.advanceTimersByTimeAsync(next(0, 400));
  }
  await vi.runAllTimersAsync();
  expect(refused).toEqual([]);
  expect(server.edits.map(({ editId }) => editId)).toEqual(ids);
  expect(server.edits.map((each) => each.active)).toEqual(ids.map((id) => active.get(id)));
});

test('an edit that the server refuses is told, and does not hold up the others', async () => {
  const server = new DraftServer();
  const { outbox, refused } = made(server);
  server.refuses = ({ author }) => author === 'bad';
  const edits = ['me', 'me', 'bad', 'me'].map((author) => edit(author));
  for (const each of edits) outbox.append(each);
  await vi.runAllTimersAsync();
  expect(refused.map(([operation, reason]) => [operation.kind === 'append' && operation.id, reason])).toEqual([[edits[2]!.editId, `edit ${edits[2]!.editId} is refused`]]);
  expect(server.edits).toHaveLength(3);
});

test('while the server is away the reason is told, and edits wait in the store', async () => {
  const server = new DraftServer();
  const { outbox, store } = made(server);
  server.before = lost;
  outbox.append(edit());
  await vi.advanceTimersByTimeAsync(10);
  expect(outbox.state).toMatchObject({ kind: 'waiting', reason: 'the gateway cannot be reached' });
  outbox.close();
  // The next page takes it over.
  server.before = () => {};
  const next = made(server, store as MemoryStore, 'next');
  next.outbox.resume(await store.list('sites/s/maps/m/drafts/d'));
  await vi.runAllTimersAsync();
  expect(server.edits).toHaveLength(1);
  expect(await store.list('sites/s/maps/m/drafts/d')).toEqual([]);
});

test('edits of a draft that was published meanwhile are kept, and not refused one by one', async () => {
  const server = new DraftServer();
  const { outbox, refused, store, end } = made(server);
  server.refuses = () => true;
  end('it is published');
  outbox.append(edit());
  await vi.runAllTimersAsync();
  expect(outbox.state).toEqual({ kind: 'ended', reason: 'it is published' });
  expect(refused).toEqual([]);
  expect(outbox.edits()).toHaveLength(1);
  await outbox.discard();
  expect(await store.list('sites/s/maps/m/drafts/d')).toEqual([]);
});

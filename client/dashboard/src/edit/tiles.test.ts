// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { ReadMapDraftTilesResponseSchema } from '../gen/enfilade/v1/map_edit_service_pb';
import { TileReader } from './tiles';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

// A map whose tiles say in their first byte of which revision they are. Answers come when `answer` is called.
function made(columns: number) {
  const server = { columns, revision: 1, calls: [] as (() => void)[] };
  const shown = new Map<number, number>();
  const service = {
    readMapDraftTiles: (({ tiles = [] }: { tiles?: { row?: number; column?: number }[] }) => {
      const answer = create(ReadMapDraftTilesResponseSchema, {
        box: { firstColumn: 0, firstRow: 0, width: 256 * server.columns, height: 256 },
        knownTiles: tiles.length > 0 ? [] : Array.from({ length: server.columns }, (_, column) => ({ row: 0, column })),
        tiles: tiles.map(({ row = 0, column = 0 }) => ({ row, column, cells: Uint8Array.of(server.revision) })),
      });
      return new Promise((resolve) => server.calls.push(() => resolve(answer)));
    }) as never,
  };
  const reader = new TileReader('sites/s/maps/m/drafts/d', service, { tile: ({ column, cells }) => shown.set(column, cells[0]!), box: () => {}, failed: () => {} });
  const answer = async (call = server.calls.shift()) => {
    call?.();
    await vi.advanceTimersByTimeAsync(0);
  };
  const answerAll = async () => {
    while (server.calls.length > 0) await answer();
  };
  return { server, reader, shown, answer, answerAll };
}

test('a new revision is read anew, with the tiles that it adds', async () => {
  const { server, reader, shown, answerAll } = made(2);
  void reader.list();
  await answerAll();
  expect([...shown.values()]).toEqual([1, 1]);
  expect(reader.idle).toBe(true);
  Object.assign(server, { revision: 2, columns: 3 });
  reader.renew();
  expect(reader.idle).toBe(false);
  await vi.advanceTimersByTimeAsync(200);
  await answerAll();
  expect([...shown.values()]).toEqual([2, 2, 2]);
  expect(reader.idle).toBe(true);
  expect(reader.progress).toEqual({ all: 3, left: 0 });
});

test('many revisions are read at most once in three seconds, and the last one is', async () => {
  const { server, reader, shown, answerAll } = made(1);
  void reader.list();
  await answerAll();
  let read = 0;
  for (let i = 0; i < 100; ++i) {
    ++server.revision;
    reader.renew();
    await vi.advanceTimersByTimeAsync(100);
    read += server.calls.length > 0 ? 1 : 0;
    await answerAll();
  }
  expect(read).toBeLessThanOrEqual(5);
  await vi.advanceTimersByTimeAsync(3000);
  await answerAll();
  expect(shown.get(0)).toBe(server.revision);
});

test('a tile that was asked for before does not come over the newer one', async () => {
  const { server, reader, shown, answer, answerAll } = made(1);
  void reader.list();
  await answer();
  const late = server.calls.shift();
  ++server.revision;
  reader.again();
  await answerAll();
  expect(shown.get(0)).toBe(2);
  await answer(late);
  expect(shown.get(0)).toBe(2);
  expect(reader.idle).toBe(true);
});

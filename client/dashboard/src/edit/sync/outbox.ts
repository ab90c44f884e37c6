// SPDX-License-Identifier: Apache-2.0
import { fromJsonString, toJsonString } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { MapEditSchema, type MapEdit } from '../../gen/enfilade/v1/map_edit_pb';
import { type AppendMapEditsResponse, type MapEditService, type SetMapEditsActiveResponse } from '../../gen/enfilade/v1/map_edit_service_pb';
import type { Client } from '@connectrpc/connect';
import { Signal } from '../../signal';
import type { Operation, OperationStore, StoredOperation } from './operations';

export type Calls = Pick<Client<typeof MapEditService>, 'appendMapEdits' | 'setMapEditsActive'>;
export type Answer = AppendMapEditsResponse | SetMapEditsActiveResponse;

// The server takes 100 edits a call, the gateway a body of 1 MiB.
const MAX_EDITS = 100;
const MAX_BYTES = 700_000;
const MAX_SWITCHED = 1000;
const BATCH_MS = 250;
const RETRIES_MS = [500, 1000, 2000, 3000, 5000];
const CALL_MS = 20_000;

export type OutboxState =
  | { kind: 'idle' }
  | { kind: 'sending' }
  // What went wrong, and when it is tried again.
  | { kind: 'waiting'; reason: string; retryAt: number }
  // The draft takes no more edits; `left` were not taken.
  | { kind: 'ended'; reason: string };

export interface OutboxEvents {
  // An answer, before `done` is called for what it answers. `knownHead`: that the call has told.
  answered(answer: Answer, knownHead: bigint): void;
  done(operation: Operation): void;
  // The server never takes it.
  refused(operation: Operation, reason: string): void;
  knownHead(): bigint;
  // Asks whether the draft still takes edits: why not.
  whyEnded(): Promise<string | undefined>;
}

interface Waiting {
  operation: Operation;
  // In the store; undefined if the browser had no space for it.
  key: Promise<number | undefined>;
}

const again = new Set([Code.Unavailable, Code.DeadlineExceeded, Code.Canceled, Code.ResourceExhausted, Code.Unknown, Code.Internal, Code.Aborted]);

// Operations on their way to the server, in their order. Each is stored first; sending one again changes nothing.
export class Outbox {
  readonly changed = new Signal();
  state: OutboxState = { kind: 'idle' };
  private readonly queue: Waiting[] = [];
  private isSending = false;
  private isFull = false;
  private failures = 0;
  // One by one, to find out which of them is refused.
  private single = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly stop = new AbortController();

  constructor(private readonly draft: string, private readonly owner: string, private readonly store: OperationStore, private readonly calls: Calls,
              private readonly events: OutboxEvents) {}

  get pending(): number {
    return this.queue.length;
  }

  // Whether what is pending survives the page.
  get isDurable(): boolean {
    return this.store.isDurable && !this.isFull;
  }

  append(edit: MapEdit) {
    this.put({ kind: 'append', id: edit.editId, edit: toJsonString(MapEditSchema, edit) });
  }

  setActive(ids: string[], active: boolean, author: string) {
    for (let i = 0; i < ids.length; i += MAX_SWITCHED) this.put({ kind: 'setActive', ids: ids.slice(i, i + MAX_SWITCHED), active, author });
  }

  // What a page that is gone has left.
  resume(stored: readonly StoredOperation[]) {
    for (const { operation, key } of stored) this.queue.push({ operation, key: Promise.resolve(key) });
    this.soon(0);
  }

  // Now rather than when the next attempt is due.
  hurry() {
    if (this.state.kind === 'waiting') this.soon(0);
  }

  close() {
    this.stop.abort();
    clearTimeout(this.timer);
  }

  private put(operation: Operation) {
    const key = this.store.add(this.draft, this.owner, operation).catch(() => {
      this.isFull = true;
      return undefined;
    });
    this.queue.push({ operation, key });
    // The first one goes at once; what comes while it is on its way goes together.
    if (!this.isSending && this.state.kind !== 'waiting') this.soon(this.queue.length === 1 ? 0 : BATCH_MS);
    this.changed.tell();
  }

  private soon(ms: number) {
    clearTimeout(this.timer);
    if (this.stop.signal.aborted || this.state.kind === 'ended') return;
    this.timer = setTimeout(() => void this.send(), ms);
  }

  // The operations of the next call, which are of one kind.
  private batch(): Waiting[] {
    const first = this.queue[0]!.operation;
    if (first.kind === 'setActive') return [this.queue[0]!];
    const limit = this.single > 0 ? 1 : MAX_EDITS;
    let bytes = 0;
    const batch: Waiting[] = [];
    for (const waiting of this.queue) {
      const { operation } = waiting;
      if (operation.kind !== 'append' || batch.length === limit) break;
      bytes += operation.edit.length;
      if (batch.length > 0 && bytes > MAX_BYTES) break;
      batch.push(waiting);
    }
    return batch;
  }

  private async send() {
    if (this.isSending || this.queue.length === 0 || this.stop.signal.aborted) return;
    this.isSending = true;
    this.set({ kind: 'sending' });
    const batch = this.batch();
    try {
      await Promise.all(batch.map(({ key }) => key));
      const knownHead = this.events.knownHead();
      const answer = await this.call(batch.map(({ operation }) => operation), knownHead);
      this.queue.splice(0, batch.length);
      this.failures = 0;
      this.single = Math.max(0, this.single - 1);
      this.events.answered(answer, knownHead);
      for (const { operation } of batch) this.events.done(operation);
      await this.forget(batch);
      this.isSending = false;
      this.set({ kind: 'idle' });
      if (this.queue.length > 0) this.soon(0);
    } catch (error) {
      this.isSending = false;
      if (!this.stop.signal.aborted) await this.fail(batch, error);
    }
  }

  private call(operations: Operation[], knownHead: bigint): Promise<Answer> {
    const options = { timeoutMs: CALL_MS, signal: this.stop.signal };
    const [first] = operations;
    if (first?.kind === 'setActive') {
      return this.calls.setMapEditsActive({ name: this.draft, editIds: first.ids, active: first.active, author: first.author, knownHead }, options);
    }
    const edits = operations.flatMap((operation) => (operation.kind === 'append' ? [fromJsonString(MapEditSchema, operation.edit)] : []));
    return this.calls.appendMapEdits({ name: this.draft, edits, knownHead }, options);
  }

  private async fail(batch: Waiting[], error: unknown) {
    const { code, rawMessage } = ConnectError.from(error);
    if (again.has(code)) return this.wait(rawMessage);
    const ended = await this.events.whyEnded().catch(() => undefined);
    if (ended !== undefined) return this.set({ kind: 'ended', reason: ended });
    if (batch.length > 1) this.single = batch.length;
    else await this.refuse(batch[0]!, rawMessage);
    this.set({ kind: 'idle' });
    this.soon(0);
  }

  private async refuse(waiting: Waiting, reason: string) {
    this.queue.shift();
    this.single = Math.max(0, this.single - 1);
    this.events.refused(waiting.operation, reason);
    await this.forget([waiting]);
  }

  // What cannot be removed from the store is sent once more by a later page, which changes nothing.
  private async forget(batch: readonly Waiting[]) {
    const keys = await Promise.all(batch.map(({ key }) => key));
    await this.store.remove(keys.filter((key) => key !== undefined)).catch(() => undefined);
  }

  private wait(reason: string) {
    const ms = RETRIES_MS[Math.min(this.failures++, RETRIES_MS.length - 1)]!;
    this.set({ kind: 'waiting', reason, retryAt: Date.now() + ms });
    this.soon(ms);
  }

  private set(state: OutboxState) {
    this.state = state;
    this.changed.tell();
  }

  // The edits that the server has not got.
  edits(): MapEdit[] {
    return this.queue.flatMap(({ operation }) => (operation.kind === 'append' ? [fromJsonString(MapEditSchema, operation.edit)] : []));
  }

  // Gives all of it up.
  async discard() {
    await this.forget(this.queue.splice(0));
    this.changed.tell();
  }
}

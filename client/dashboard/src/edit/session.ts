// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError, type Client } from '@connectrpc/connect';
import { fromJson } from '@bufbuild/protobuf';
import { maps } from '../api/clients';
import { hex } from '../api/digests';
import { mapOfDraft } from '../api/names';
import { MapDraft_State, type MapDraft, type MapEdit } from '../gen/enfilade/v1/map_edit_pb';
import { WatchMapDraftResponseSchema, type MapDraftPresence, type MapDraftTile, type MapEditService, type MapEditTile, type WatchMapDraftResponse } from '../gen/enfilade/v1/map_edit_service_pb';
import { keepStream } from '../live/eventStream';
import { Signal } from '../signal';
import { Draft } from './draft';
import { LatticeFrame } from './frame';
import { History } from './history';
import { uuid } from './ids';
import { MAX_CELLS, type Box } from './lattice';
import { Overlay, type Tile } from './overlay';
import { cellCount, TILE_CELLS, touches, type Spans } from './raster/spans';
import { openStore, type Operation } from './sync/operations';
import { Outbox, type Answer } from './sync/outbox';
import { Presence, takeOver } from './sync/owners';
import { TileReader } from './tiles';

// The server sends at most so many edits in a message of a watch.
const FULL_MESSAGE = 100;
// Digests are made a few at a time, so that drawing stays fluid.
const VERIFIED_AT_ONCE = 4;

export type StreamState = { kind: 'connecting' } | { kind: 'live' } | { kind: 'lost'; since: number; retryAt: number; reason: string };

// A draft that is open on a page: its cells, what is on its way to the server, and what others do meanwhile.
export class EditSession {
  readonly changed = new Signal();
  // Grows with each change.
  version = 0;
  // Called when cells may look otherwise.
  touched: (tile: Tile, firstRow: number, endRow: number, firstColumn: number, endColumn: number) => void = () => {};
  readonly draft: Draft;
  readonly history: History;
  readonly frame: LatticeFrame;
  readonly clientId = uuid();
  outbox!: Outbox;
  readonly tiles: TileReader;
  // The map's cells.
  box: Box | undefined;
  // The newest of the map's publications.
  editVersion = 0n;
  // Of the map, that robots or people have made last; empty: not known yet.
  revision = '';
  presences: readonly MapDraftPresence[] = [];
  stream: StreamState = { kind: 'connecting' };
  isDeleted = false;
  // The map that the draft's map was merged into, and the draft with it.
  mergedInto: string | undefined;
  // All edits that there were are here.
  isComplete = false;
  // What the server has not taken, and why.
  refusals: string[] = [];
  tilesFailed: string | undefined;
  // Tiles that were other than the server says; 0 unless a rasteriser is wrong.
  mismatches = 0;
  verified = 0;
  private readonly owner = new Presence(this.clientId);
  private stopWatching = () => {};
  private readonly onOnline = () => this.outbox.hurry();
  private isClosed = false;

  constructor(public state: MapDraft, readonly author: () => string, private readonly service: Client<typeof MapEditService>) {
    const overlay = new Overlay((...what) => this.touched(...what), (row, column) => this.tiles.want(row, column));
    this.draft = new Draft(overlay);
    this.history = new History(this.draft.isActive);
    this.frame = new LatticeFrame(state.lattice);
    this.tiles = new TileReader(state.name, service, {
      tile: (tile, head) => this.takeTile(tile, head),
      box: (box) => {
        this.box = box;
        this.tell();
      },
      failed: (text) => {
        this.tilesFailed = text;
        this.tell();
      },
    });
  }

  get name(): string {
    return this.state.name;
  }
  // Whether it takes edits.
  get isOpen(): boolean {
    return !this.isDeleted && this.state.state === MapDraft_State.OPEN && this.outbox.state.kind !== 'ended';
  }
  // Everything is drawn, sent and acknowledged.
  get isSettled(): boolean {
    return this.isComplete && this.outbox.pending === 0 && this.tiles.idle;
  }

  async start() {
    const store = await openStore();
    this.outbox = new Outbox(this.name, this.owner.owner, store, this.service, {
      answered: (answer, knownHead) => this.takeAnswer(answer, knownHead),
      done: (operation) => operation.kind === 'setActive' && this.draft.settle(operation.ids),
      refused: (operation, reason) => this.refuse(operation, reason),
      knownHead: () => this.draft.head,
      whyEnded: () => this.whyEnded(),
    });
    this.outbox.changed.subscribe(() => this.tell());
    await this.restore(await takeOver(store, this.name, this.owner).catch(() => []));
    if (this.isClosed) return;
    this.watch();
    window.addEventListener('online', this.onOnline);
    void this.tiles.list();
    this.tell();
  }

  close() {
    this.isClosed = true;
    this.stopWatching();
    window.removeEventListener('online', this.onOnline);
    this.outbox?.close();
    this.owner.close();
    this.tiles.close();
  }

  // Draws edits of one gesture and sends them. Returns why not. `spans`: the cells of the only one.
  add(edits: MapEdit[], spans?: Spans): string | undefined {
    const all = edits.map((edit) => [edit, spans ?? this.draft.cellsOf(edit)] as const);
    for (const [edit, cells] of all) {
      const problem = this.problemOf(edit, cells);
      if (problem !== undefined) return problem;
    }
    for (const [edit, cells] of all) {
      this.draft.draw(edit, cells);
      this.outbox.append(edit);
    }
    this.history.add(edits.map(({ editId }) => editId));
    this.tell();
    return undefined;
  }

  // Why the server would not take it, as far as that is known here.
  private problemOf({ shape, onlyWhere }: MapEdit, cells: Spans): string | undefined {
    if (shape.case === 'fill') return undefined;
    const count = cellCount(cells);
    if (count > MAX_CELLS) return `This shape has ${count.toLocaleString('en')} cells, an edit at most ${MAX_CELLS.toLocaleString('en')}: draw it in parts.`;
    if (count === 0) return onlyWhere.length > 0 ? 'No cell there is one of those that are ticked.' : 'It covers the middle of no cell: draw it larger.';
    return this.box && !touches(cells, this.box) ? 'It lies outside of the map: draw within its border.' : undefined;
  }

  undo = () => this.turn(this.history.undo(), false);
  redo = () => this.turn(this.history.redo(), true);

  // Whether there was something to undo or redo.
  private turn(ids: string[], active: boolean): boolean {
    if (ids.length === 0) return false;
    this.draft.setActive(ids, active);
    // The name may have been changed since.
    for (const author of new Set(ids.map(this.authorOf))) this.outbox.setActive(ids.filter((id) => this.authorOf(id) === author), active, author);
    this.tell();
    return true;
  }

  private readonly authorOf = (id: string) => this.draft.entries.get(id)?.edit.author ?? this.author();

  // What was drawn before the page was closed or broke down.
  private async restore(left: Awaited<ReturnType<typeof takeOver>>) {
    this.outbox.resume(left);
    for (const edit of this.outbox.edits()) this.draft.draw(edit);
    for (const { operation } of left) if (operation.kind === 'setActive') this.draft.setActive(operation.ids, operation.active);
  }

  private watch() {
    this.stopWatching = keepStream({
      address: () => `/v1/${this.name}:watch?afterHead=${this.draft.head}`,
      take: (json) => this.takeMessage(fromJson(WatchMapDraftResponseSchema, json, { ignoreUnknownFields: true })),
      probe: async () => (await this.whyEnded()) !== undefined,
      lost: (since, retryAt, reason) => this.setStream({ kind: 'lost', since, retryAt, reason }),
      refused: (error) => this.setStream({ kind: 'lost', since: Date.now(), retryAt: Infinity, reason: ConnectError.from(error).rawMessage }),
    });
  }

  private tell() {
    ++this.version;
    this.changed.tell();
  }

  private setStream(state: StreamState) {
    this.stream = state;
    this.tell();
  }

  private takeMessage(message: WatchMapDraftResponse) {
    this.draft.take(message.edits);
    // After a full message there may be more of its last head.
    const isAll = message.edits.length < FULL_MESSAGE;
    this.reach(isAll ? message.head : message.edits.at(-1)!.head - 1n);
    if (message.presencesChanged) this.presences = message.presences;
    if (message.draft) this.takeState(message.draft);
    this.editVersion = message.editVersion;
    if (!this.isComplete && isAll) {
      this.isComplete = true;
      this.history.remember(this.draft.entries.values(), this.author());
    }
    if (this.stream.kind !== 'live') this.outbox.hurry();
    this.setStream({ kind: 'live' });
  }

  // The newest revision of the map, each time and before `start`: another one has other evidence, which is read anew under
  // all that is drawn.
  see(revision = '') {
    if (revision === this.revision || revision === '') return;
    const isFirst = this.revision === '';
    this.revision = revision;
    if (!isFirst) this.tiles.renew();
    this.tell();
  }

  takeState(state: MapDraft) {
    const isMoved = state.baseEditVersion !== this.state.baseEditVersion;
    this.state = state;
    if (isMoved) this.tiles.again();
    if (state.state === MapDraft_State.PUBLISHED) this.stopWatching();
    this.tell();
  }

  private reach(head: bigint) {
    if (head > this.draft.head) this.draft.head = head;
  }

  private takeAnswer(answer: Answer, knownHead: bigint) {
    this.draft.take(answer.edits);
    // Without a known head it tells only what the call itself has changed.
    if (knownHead > 0n) this.reach(answer.head);
    if (this.isComplete && this.draft.head === answer.head && this.draft.newest <= answer.head) void this.verify(answer.tiles, answer.head);
  }

  // The server's word is final: a tile that is otherwise here is read again, and counted.
  private async verify(tiles: readonly MapEditTile[], head: bigint) {
    for (let i = 0; i < tiles.length; ++i) {
      if (i % VERIFIED_AT_ONCE === VERIFIED_AT_ONCE - 1) await new Promise((resolve) => setTimeout(resolve));
      if (this.draft.head !== head || this.draft.newest > head) return;
      const { row, column, sha256 } = tiles[i]!;
      if (!this.draft.overlay.tile(row, column).loaded) continue;
      ++this.verified;
      if (this.draft.storedDigest(row, column) === hex(sha256)) continue;
      ++this.mismatches;
      this.tiles.want(row, column);
    }
  }

  private takeTile({ row, column, cells }: MapDraftTile, head: bigint) {
    if (cells.length !== TILE_CELLS) return;
    const { overlay } = this.draft;
    overlay.load(row, column, cells);
    const isSame = this.isComplete && this.outbox.pending === 0 && head === this.draft.head && this.draft.newest <= head;
    if (isSame && !cells.every((cell, i) => cell === overlay.tile(row, column).cells[i])) {
      ++this.mismatches;
      overlay.trust(row, column, cells);
    }
    this.tell();
  }

  private refuse(operation: Operation, reason: string) {
    if (operation.kind === 'append') {
      this.draft.drop(operation.id);
      this.history.forget(operation.id);
    } else {
      this.draft.settle(operation.ids);
    }
    // Which of the edits that were sent together does not matter to a person.
    this.refusals = [...this.refusals, reason.replace(/^edits\[\d+\] \([^)]*\): /, '')];
    this.tell();
  }

  // Those that are on and the server has not got.
  leftEdits(): MapEdit[] {
    return this.outbox.edits().filter(({ editId }) => this.draft.isActive(editId));
  }

  async giveUp() {
    for (const { editId } of this.outbox.edits()) {
      this.draft.drop(editId);
      this.history.forget(editId);
    }
    await this.outbox.discard();
    this.tell();
  }

  dismiss() {
    this.refusals = [];
    this.tell();
  }

  // Why the draft takes no more edits; undefined if it does.
  private async whyEnded(): Promise<string | undefined> {
    try {
      const { draft } = await this.service.getMapDraft({ name: this.name }, { timeoutMs: 5000 });
      if (draft) this.takeState(draft);
      return draft?.state === MapDraft_State.PUBLISHED ? 'it is published' : undefined;
    } catch (error) {
      if (ConnectError.from(error).code !== Code.NotFound) throw error;
      // The old name of a map that was merged leads to the one that stays.
      const name = mapOfDraft(this.name);
      const { map } = await maps.getMap({ name }, { timeoutMs: 5000 }).catch(() => ({ map: undefined }));
      this.isDeleted = true;
      this.mergedInto = map && map.name !== name ? map.name : undefined;
      this.tell();
      return this.mergedInto === undefined ? 'it is deleted' : 'its map was merged into another one';
    }
  }
}

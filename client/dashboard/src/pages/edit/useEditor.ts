// SPDX-License-Identifier: Apache-2.0
import { useEffect, useState, useSyncExternalStore } from 'react';
import { mapEdits } from '../../api/clients';
import { mapOfDraft } from '../../api/names';
import { Board } from '../../edit/board/Board';
import { UNITS } from '../../edit/lattice';
import { EditSession } from '../../edit/session';
import { PointerReport } from '../../edit/tools/pointer';
import { ToolSettings } from '../../edit/tools/settings';
import type { MapDraft } from '../../gen/enfilade/v1/map_edit_pb';
import { useLive } from '../../live/context';
import type { Point } from '../../scene/camera';
import { Signal } from '../../signal';
import { author } from './author';

// What the page shows beside the canvas, and changes with it.
export class EditorState {
  readonly settings = new ToolSettings();
  readonly board: Board;
  readonly report: PointerReport;
  // What the editor has to say on the last thing that was done.
  said = '';
  pointer: Point | undefined;
  // Of the area that is drawn or edited, in metres of the map.
  outline: readonly Point[] | undefined;
  isPublishing = false;
  version = 0;
  readonly changed = new Signal();
  readonly pointerMoved = new Signal();

  constructor(readonly session: EditSession) {
    this.report = new PointerReport(session.name, session.clientId, author.get, mapEdits);
    this.board = new Board(session, this.settings, this.report, {
      hover: (at) => {
        this.pointer = at;
        this.pointerMoved.tell();
      },
      said: (text) => this.say(text),
      area: (ring) => this.set({ outline: ring.map(({ x, y }) => session.frame.metres({ x: x / UNITS, y: y / UNITS })) }),
    });
    this.settings.changed.subscribe(() => this.set({}));
    session.changed.subscribe(() => this.set({}));
  }

  say = (said: string) => {
    if (said !== this.said) this.set({ said });
  };

  set(changes: Partial<Pick<EditorState, 'said' | 'outline' | 'isPublishing'>>) {
    Object.assign(this, changes);
    ++this.version;
    this.changed.tell();
  }

  close() {
    this.board.close();
    this.report.close();
    this.session.close();
  }
}

declare global {
  interface Window {
    // The open draft, for tests.
    __editor?: ReturnType<typeof forTests>;
  }
}

function forTests({ board, session }: EditorState) {
  return {
    camera: () => board.camera,
    setCamera: (camera: { x: number; y: number; scale: number }) => board.setCamera(camera),
    settled: () => board.isSettled,
    // The byte of a cell.
    cell: (row: number, column: number) => session.draft.overlay.at(row, column),
    // Of what edits say, by "row,column" of the tile.
    digests: () => Object.fromEntries([...session.draft.overlay.tiles.values()].map(({ row, column }) => [`${row},${column}`, session.draft.overlay.digest(row, column)])),
    stats: () => ({
      pending: session.outbox?.pending ?? 0, head: Number(session.draft.head), edits: session.draft.entries.size, mismatches: session.mismatches, verified: session.verified,
      refusals: session.refusals, tiles: session.tiles.progress, frameMs: board.frameMs, stream: session.stream.kind, presences: session.presences.map(({ author: name }) => name),
    }),
  };
}

// One session for as long as the component shows the draft.
export function useEditor(draft: MapDraft): EditorState | undefined {
  const [editor, setEditor] = useState<EditorState>();
  const live = useLive();
  useEffect(() => {
    const session = new EditSession(draft, author.get, mapEdits);
    const see = () => session.see(live.rasters.get(mapOfDraft(draft.name))?.revision);
    see();
    const unsubscribe = live.subscribe(see);
    const made = new EditorState(session);
    window.__editor = forTests(made);
    let isOver = false;
    void session.start().then(() => isOver || setEditor(made));
    return () => {
      isOver = true;
      unsubscribe();
      delete window.__editor;
      made.close();
    };
  }, [draft, live]);
  return editor;
}

// Draws the component again when something has changed.
export function useVersion(of: { changed: Signal; version: number }): number {
  return useSyncExternalStore(of.changed.subscribe, () => of.version);
}

// SPDX-License-Identifier: Apache-2.0
import { useEffect, useRef, useState } from 'react';
import { idOf, mapOfDraft } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { LatticeFrame } from '../../edit/frame';
import { listenToKeys } from '../../edit/keys';
import { united, type Box } from '../../edit/lattice';
import { MapDraft_State, type ContestedEdit, type MapDraft } from '../../gen/enfilade/v1/map_edit_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { count } from '../../ui/format';
import { Loading } from '../../ui/States';
import { ToolButton } from '../../scene/SceneView';
import { AreaHandles } from './AreaHandles';
import { Areas } from './Areas';
import { AuthorLine } from './AuthorForm';
import { Contested } from './Contested';
import { editAddress } from './DraftList';
import { NumbersForm } from './NumbersForm';
import { People } from './People';
import { PublishDialog } from './PublishDialog';
import { Status } from './Status';
import { SyncState } from './SyncState';
import { ToolBar } from './ToolBar';
import { ToolOptions } from './ToolOptions';
import { useEditor, useVersion, type EditorState } from './useEditor';

// In cells of the draft's lattice, of a place that may be on another one.
function boxOf(frame: LatticeFrame, { box, lattice }: ContestedEdit): Box | undefined {
  if (!box) return undefined;
  const own = new LatticeFrame(lattice);
  const corners = [0, 1].flatMap((i) => [0, 1].map((j) => frame.cells(own.metres({ x: box.firstColumn + i * box.width, y: box.firstRow + j * box.height }))));
  return corners.map(({ x, y }) => ({ firstColumn: Math.round(x), firstRow: Math.round(y), width: 0, height: 0 })).reduce<Box | undefined>(united, undefined);
}

function Canvas({ editor }: { editor: EditorState }) {
  const { board } = editor;
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    host.current?.append(board.canvas);
    return () => board.canvas.remove();
  }, [board]);
  return (
    <div className="scene edit-scene">
      <div className="scene-host" ref={host} />
      <AreaHandles editor={editor} />
      <div className="scene-tools" role="toolbar" aria-label="Map">
        <ToolButton icon="plus" title="Zoom in" keys="+" onClick={() => board.zoom(1.5)} />
        <ToolButton icon="minus" title="Zoom out" keys="-" onClick={() => board.zoom(1 / 1.5)} />
        <ToolButton icon="fit" title="Show all" keys="0" onClick={() => board.fit()} />
      </div>
      <ToolBar editor={editor} />
      <Status editor={editor} />
    </div>
  );
}

function Head({ editor }: { editor: EditorState }) {
  const live = useLive();
  const { state, editVersion, revision } = editor.session;
  const later = Number(editVersion - state.baseEditVersion);
  const map = mapOfDraft(state.name);
  return (
    <div className="map-head">
      <h1>{state.displayName || `Draft ${idOf(state.name).slice(0, 8)}`}</h1>
      <p className="sub">
        A draft of <Link href={addressOf(live.id, 'maps', [idOf(map)])}>{titleOf(live, map)}</Link> by {state.author}{revision !== '' && `, over revision ${idOf(revision)}`} · <Link href={editAddress(live.id, map)}>All drafts</Link>
      </p>
      {state.state === MapDraft_State.OPEN && later > 0 && <p className="sub">{count(later, 'publication')} of this map came since the draft began. They are put together when it is published.</p>}
      {state.state === MapDraft_State.PUBLISHED && (
        <p role="status">
          It is published{state.revision !== '' && <>: <Link href={addressOf(live.id, 'maps', [idOf(map)], { rev: idOf(state.revision) })}>revision {idOf(state.revision)}</Link></>}. Edit the map further in a new draft.
        </p>
      )}
    </div>
  );
}

function Panel({ editor }: { editor: EditorState }) {
  const { session, board } = editor;
  const show = (box: Box | undefined) => {
    board.boxes = box ? [box] : [];
    if (box) board.fit(box);
  };
  return (
    <aside className="panel edit-panel" aria-label="Details">
      <Head editor={editor} />
      <SyncState session={session} />
      <div className="actions">
        <button className="button primary" disabled={!session.isOpen} aria-keyshortcuts="Control+s" onClick={() => editor.set({ isPublishing: true })}>
          Publish …
        </button>
        <button className="button" disabled={!session.isOpen || !session.history.canUndo} aria-keyshortcuts="Control+z" onClick={() => session.undo()}>
          Undo
        </button>
        <button className="button" disabled={!session.isOpen || !session.history.canRedo} aria-keyshortcuts="Control+Shift+z" onClick={() => session.redo()}>
          Redo
        </button>
      </div>
      <ToolOptions editor={editor} />
      <NumbersForm editor={editor} />
      <Areas editor={editor} map={mapOfDraft(session.name)} />
      <Contested map={mapOfDraft(session.name)} show={(edit) => show(boxOf(session.frame, edit))} />
      <People session={session} />
      <AuthorLine />
    </aside>
  );
}

function OpenEditor({ editor }: { editor: EditorState }) {
  useVersion(editor);
  useEffect(() => listenToKeys({ board: editor.board, publish: () => editor.session.isOpen && editor.set({ isPublishing: true }), undone: editor.say }), [editor]);
  return (
    <div className="campus">
      <Canvas editor={editor} />
      <Panel editor={editor} />
      {editor.isPublishing && <PublishDialog editor={editor} map={mapOfDraft(editor.session.name)} close={() => editor.set({ isPublishing: false })} />}
    </div>
  );
}

export function Editor({ draft }: { draft: MapDraft }) {
  // The session has its own news of the draft.
  const [opened] = useState(draft);
  const editor = useEditor(opened);
  return editor ? <OpenEditor editor={editor} /> : <Loading />;
}


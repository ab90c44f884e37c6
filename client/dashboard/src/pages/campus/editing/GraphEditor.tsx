// SPDX-License-Identifier: Apache-2.0
import './editing.css';
import { useEffect, useMemo, useRef, useState } from 'react';
import { collectionOf } from '../../../api/names';
import { setQuery } from '../../../app/router';
import { select, useLevel, useSelection } from '../../../app/selection';
import { useLive } from '../../../live/context';
import { SceneView } from '../../../scene/SceneView';
import type { SceneEvents } from '../../../scene/Scene';
import { ObjectList } from '../ObjectList';
import { Readout, type ReadoutHandle } from '../Readout';
import { AlignHandles } from './AlignHandles';
import { AlignPanel } from './AlignPanel';
import { AnchorHandles } from './AnchorHandles';
import { EditorHead } from './EditorHead';
import { SelectionForm } from './SelectionForm';
import { useEditor } from './useEditor';

// Keys that hold wherever the focus is.
function useKeys(keys: Record<string, () => void>) {
  const current = useRef(keys);
  current.current = keys;
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (!event.ctrlKey && !event.metaKey) return;
      const act = current.current[`${event.shiftKey ? 'shift+' : ''}${event.key.toLowerCase()}`];
      if (!act) return;
      event.preventDefault();
      act();
    };
    window.addEventListener('keydown', onKey);
    return () => window.removeEventListener('keydown', onKey);
  }, []);
}

// Nobody loses changes by closing the page.
function useLeavingQuestion(isDrafting: boolean) {
  useEffect(() => {
    if (!isDrafting) return;
    const onLeave = (event: BeforeUnloadEvent) => event.preventDefault();
    window.addEventListener('beforeunload', onLeave);
    return () => window.removeEventListener('beforeunload', onLeave);
  }, [isDrafting]);
}

// The campus on which link points are changed: the draft, what it would do, and its saving.
export default function GraphEditor() {
  const live = useLive();
  const level = useLevel();
  const selected = useSelection();
  const readout = useRef<ReadoutHandle>(null);
  const [asking, setAsking] = useState(false);
  const editor = useEditor(live, level, selected);
  const { drafting, align, held, selection } = editor;
  const isDrafting = drafting.draft.size > 0;
  useLeavingQuestion(isDrafting);
  useKeys({ z: () => drafting.step('undo'), 'shift+z': () => drafting.step('redo'), y: () => drafting.step('redo'), s: () => editor.maySave && editor.save.mutate() });

  const close = () => (isDrafting ? setAsking(true) : setQuery({ edit: undefined }));
  const events: SceneEvents = {
    hover: (...over) => readout.current?.hover(...over),
    click: (what) => align.pair === undefined && (what === undefined || ['maps', 'linkPoints'].includes(collectionOf(what))) && select(what),
    key: (key) => {
      if (key === 'e') close();
      else if (key === 'Escape') align.pair ? align.end() : select(undefined);
      else return false;
      return true;
    },
  };
  const said = useMemo(() => {
    if (held && live.graphVersion !== held.version) return `Version ${live.graphVersion} of the graph has come: it is applied when you let go`;
    return align.pair ? 'Aligning two maps' : 'Editing the graph: nothing changes until you save';
  }, [held, live.graphVersion, align.pair]);
  return (
    <div className="campus">
      <SceneView view={editor.view} events={events}>
        {align.pair ? (
          <AlignHandles map={align.pair.b} title={editor.titleOf(align.pair.b)} base={editor.base} guess={align.pair.guess} change={align.move} />
        ) : (
          selection && !selection.edit.isDeleted && (
            <AnchorHandles key={selection.edit.base.name} anchors={selection.shown} active={selection.active} choose={editor.choose} hold={editor.hold} change={editor.change} undo={() => drafting.step('undo')} />
          )
        )}
        <Readout ref={readout} said={said} />
      </SceneView>
      <aside className="panel" aria-label="Details">
        <EditorHead editor={editor} asking={asking} setAsking={setAsking} close={close} />
        {align.pair ? <AlignPanel key={`${align.pair.a} ${align.pair.b}`} pair={align.pair} align={align} titleOf={editor.titleOf} make={editor.makeOfFit} isDrafting={isDrafting} /> : <SelectionForm editor={editor} selected={selected} />}
        {!align.pair && <ObjectList level={level} />}
      </aside>
    </div>
  );
}

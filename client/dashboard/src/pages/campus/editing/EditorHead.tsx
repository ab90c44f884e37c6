// SPDX-License-Identifier: Apache-2.0
import { problemOf } from '../../../api/errors';
import { setQuery } from '../../../app/router';
import { count } from '../../../ui/format';
import { Icon } from '../../../ui/Icon';
import { ConflictNotice } from './Conflicts';
import { PreviewFacts } from './PreviewFacts';
import type { Editor } from './useEditor';

// What the button of saving says: nobody saves a contradiction without having read of it.
function saveText({ preview: { effects } }: Editor): string {
  const off = effects?.switchedOff.length ?? 0;
  const lost = effects?.lost.length ?? 0;
  if (off === 0 && lost === 0) return 'Save';
  const parts = [off > 0 && `${count(off, 'link point is', 'link points are')} switched off`, lost > 0 && `${count(lost, 'map loses its place', 'maps lose their places')}`].filter(Boolean);
  return `Save although ${parts.join(' and ')}`;
}

interface Props {
  editor: Editor;
  asking: boolean;
  setAsking: (on: boolean) => void;
  close: () => void;
}

// The draft as a whole: what it would do, saving, undoing, and what others have changed meanwhile.
export function EditorHead({ editor, asking, setAsking, close }: Props) {
  const { drafting: { draft, step, canUndo, canRedo }, preview, conflicts, save, maySave, titleOf, forget } = editor;
  return (
    <section className="inspector" aria-label="Changes of the graph">
      <div className="inspector-head">
        <Icon name="edit" />
        <div className="inspector-title">
          <h1>Edit the graph</h1>
          <span className="sub" role="status">
            {draft.size === 0 ? 'Nothing is changed' : `${count(draft.size, 'link point is', 'link points are')} changed, not saved`}
          </span>
        </div>
        <button className="button icon plain" aria-label="End editing" title="End editing (e)" onClick={close}>
          <Icon name="close" />
        </button>
      </div>
      <div className="actions">
        <button className="button primary" disabled={!maySave} aria-keyshortcuts="Control+S" onClick={() => save.mutate()}>
          {saveText(editor)}
        </button>
        <button className="button" disabled={!canUndo} aria-keyshortcuts="Control+Z" onClick={() => step('undo')}>
          Undo
        </button>
        <button className="button" disabled={!canRedo} aria-keyshortcuts="Control+Shift+Z" onClick={() => step('redo')}>
          Redo
        </button>
        <button className="button" disabled={draft.size === 0} onClick={() => step('forget')}>
          Discard
        </button>
      </div>
      {asking && draft.size > 0 && (
        <p className="refusal" role="alert">
          Your changes are not saved.{' '}
          <button className="button" onClick={() => (step('forget'), setQuery({ edit: undefined }))}>
            Discard them and end
          </button>{' '}
          <button className="button" autoFocus onClick={() => setAsking(false)}>
            Go on
          </button>
        </p>
      )}
      {conflicts.map((conflict) => (
        <ConflictNotice key={conflict.edit.base.name} conflict={conflict} titleOf={titleOf} takeTheirs={() => forget(conflict.edit.base.name)} layMine={(theirs) => step({ theirs })} />
      ))}
      {save.error && conflicts.length === 0 && draft.size > 0 && (
        <p className="refusal" role="alert">
          {problemOf(save.error).title}: {problemOf(save.error).text}
        </p>
      )}
      {draft.size > 0 && (conflicts.length === 0 || preview.error === undefined) && <PreviewFacts preview={preview} titleOf={titleOf} suspend={editor.suspend} />}
      {draft.size === 0 && save.data && <p role="status">Saved as version {String(save.data.graphVersion)} of the graph.</p>}
    </section>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { useEffect, useRef, useState, type FormEvent } from 'react';
import { mapEdits } from '../../api/clients';
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import type { Box } from '../../edit/lattice';
import { changesText } from '../../edit/words';
import { MapEditProblem_Severity as Severity, type CheckMapDraftResponse, type MapEditProblem, type PublishMapDraftResponse } from '../../gen/enfilade/v1/map_edit_service_pb';
import { useLive } from '../../live/context';
import { count } from '../../ui/format';
import { refusalOf } from '../../ui/Sending';
import { author } from './author';
import { Conflicts, type Choices } from './Conflicts';
import type { EditorState } from './useEditor';

function Problems({ problems, show }: { problems: MapEditProblem[]; show: (box: Box) => void }) {
  return (
    <ul className="edit-problems" aria-label="Problems">
      {problems.map(({ severity, message, box }, i) => (
        <li key={i} className={severity === Severity.ERROR ? 'refusal' : 'edit-warning'}>
          <strong>{severity === Severity.ERROR ? 'Error' : 'Warning'}:</strong> {message}{' '}
          {box && (
            <button className="button small-text" type="button" onClick={() => show(box)}>
              Show
            </button>
          )}
        </li>
      ))}
    </ul>
  );
}

function Published({ result, map }: { result: PublishMapDraftResponse; map: string }) {
  const live = useLive();
  const revision = idOf(result.revision?.name ?? '');
  const merged = Number(result.mergedPublications);
  return (
    <div role="status">
      <p>
        Published: <Link href={addressOf(live.id, 'maps', [idOf(map)], { rev: revision })}>revision {revision}</Link>. {changesText(result.changes)}.
      </p>
      {merged > 0 && <p>It was put together with {count(merged, 'publication')} that came meanwhile; nothing of either was lost.</p>}
    </div>
  );
}

interface FormProps {
  editor: EditorState;
  check: CheckMapDraftResponse;
  again: () => void;
  publish: (message: string, confirmWarnings: boolean) => void;
  isBusy: boolean;
  show: (box: Box) => void;
}

// What would change, and what speaks against it.
function PublishForm({ editor, check, again, publish, isBusy, show }: FormProps) {
  const [message, setMessage] = useState('');
  const [isConfirmed, setConfirmed] = useState(false);
  const { frame, state } = editor.session;
  const errors = check.problems.filter(({ severity }) => severity === Severity.ERROR);
  const warnings = check.problems.length - errors.length;
  const later = Number(check.editVersion - state.baseEditVersion);
  const isBlocked = errors.length > 0 || check.conflicts.length > 0 || (warnings > 0 && !isConfirmed) || message.trim() === '';
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    if (!isBlocked) publish(message.trim(), isConfirmed);
  };
  return (
    <form className="edit-publish" aria-label="Publish" onSubmit={onSubmit} noValidate>
      <p>
        {changesText(check.changes)}
        {check.box && `, within ${frame.place(check.box)}`}.{' '}
        {check.box && (
          <button className="button small-text" type="button" onClick={() => show(check.box!)}>
            Show
          </button>
        )}
      </p>
      {later > 0 && check.conflicts.length === 0 && <p className="sub">{count(later, 'publication')} came since this draft began. They say nothing different about the same cells: both will be in.</p>}
      <Problems problems={check.problems} show={show} />
      {warnings > 0 && (
        <label>
          <input type="checkbox" checked={isConfirmed} onChange={(event) => setConfirmed(event.target.checked)} /> Publish in spite of {count(warnings, 'warning')}
        </label>
      )}
      <label className="edit-message">
        What was edited, and why
        <input className="field" maxLength={500} autoFocus value={message} onChange={(event) => setMessage(event.target.value)} />
      </label>
      <div className="actions">
        <button className="button primary" disabled={isBlocked || isBusy}>
          Publish
        </button>
        <button className="button" type="button" disabled={isBusy} onClick={again}>
          Check again
        </button>
      </div>
      {errors.length > 0 && <p className="sub">Errors must be taken away before it can be published.</p>}
    </form>
  );
}

type Stage = { kind: 'checking' } | { kind: 'checked'; check: CheckMapDraftResponse } | { kind: 'failed' } | { kind: 'done'; result: PublishMapDraftResponse };

export function PublishDialog({ editor, map, close }: { editor: EditorState; map: string; close: () => void }) {
  const { session, board } = editor;
  const dialog = useRef<HTMLDialogElement>(null);
  const [stage, setStage] = useState<Stage>({ kind: 'checking' });
  const [problem, setProblem] = useState('');
  const [isBusy, setBusy] = useState(false);
  const pending = session.outbox.pending;

  const attempt = async (act: () => Promise<Stage>, otherwise?: Stage) => {
    setBusy(true);
    setProblem('');
    try {
      setStage(await act());
    } catch (error) {
      setProblem(refusalOf(error));
      if (otherwise) setStage(otherwise);
    } finally {
      setBusy(false);
    }
  };
  const checked = async (): Promise<Stage> => {
    // The server checks what it has.
    const [{ draft }, check] = [await mapEdits.getMapDraft({ name: session.name }), await mapEdits.checkMapDraft({ name: session.name })];
    if (draft) session.takeState(draft);
    return { kind: 'checked', check };
  };
  const check = () => void attempt(checked, { kind: 'failed' });
  const rebase = (check: CheckMapDraftResponse, choices: Choices) => void attempt(async () => {
    const resolutions = check.conflicts.map(({ box }, i) => ({ choice: choices[i]!, ...(box && { box }) }));
    const { draft } = await mapEdits.rebaseMapDraft({ name: session.name, editVersion: check.editVersion, resolutions, author: author.get() });
    if (draft) session.takeState(draft);
    return checked();
  });
  const publish = (head: bigint) => (message: string, confirmWarnings: boolean) => void attempt(async () => {
    const result = await mapEdits.publishMapDraft({ name: session.name, etag: session.state.etag, expectedHead: head, message, confirmWarnings });
    if (result.draft) session.takeState(result.draft);
    return { kind: 'done', result };
  });
  useEffect(() => {
    dialog.current?.showModal();
    return () => {
      board.boxes = [];
      board.touch();
    };
  }, [board]);
  useEffect(() => {
    if (pending === 0 && stage.kind === 'checking' && !isBusy) check();
  }, [pending]);

  const show = (box: Box) => {
    board.boxes = [box];
    board.fit(box);
  };
  return (
    <dialog ref={dialog} className="edit-dialog" aria-labelledby="publish-title" onClose={close}>
      <div className="edit-dialog-head">
        <h1 id="publish-title">Publish the draft</h1>
        <button className="button small-text" type="button" onClick={() => dialog.current?.close()}>
          Close
        </button>
      </div>
      {stage.kind === 'checking' && <p role="status">{pending > 0 ? `${count(pending, 'edit')} not stored yet: the check begins when all are …` : 'Checking …'}</p>}
      {stage.kind === 'checked' && stage.check.conflicts.length > 0 && <Conflicts key={String(stage.check.head)} check={stage.check} frame={session.frame} isBusy={isBusy} show={show} resolve={(choices) => rebase(stage.check, choices)} />}
      {stage.kind === 'checked' && <PublishForm editor={editor} check={stage.check} again={check} isBusy={isBusy} show={show} publish={publish(stage.check.head)} />}
      {stage.kind === 'done' && <Published result={stage.result} map={map} />}
      {problem !== '' && <p className="refusal" role="alert">{problem}</p>}
      {problem !== '' && stage.kind === 'failed' && (
        <button className="button" disabled={isBusy} onClick={check}>
          Check again
        </button>
      )}
    </dialog>
  );
}

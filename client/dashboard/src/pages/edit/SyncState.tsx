// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';
import { mapEdits } from '../../api/clients';
import { mapOfDraft } from '../../api/names';
import { Link, navigate } from '../../app/router';
import { uuid } from '../../edit/ids';
import type { EditSession } from '../../edit/session';
import { useLive, useNow } from '../../live/context';
import { titleOf } from '../../live/objects';
import { Badge } from '../../ui/Badge';
import { count } from '../../ui/format';
import { refusalOf } from '../../ui/Sending';
import { author } from './author';
import { editAddress } from './DraftList';
import { Sure } from './Sure';

function Waiting({ reason, retryAt }: { reason: string; retryAt: number }) {
  const now = useNow(500);
  const seconds = Math.max(0, Math.ceil((retryAt - now) / 1000));
  return (
    <>
      : {reason}. {seconds > 0 ? `Next attempt in ${seconds} s.` : 'Sending …'}
    </>
  );
}

// Edits that came too late for the draft: they go into a new one, or are given up.
function Left({ session, reason }: { session: EditSession; reason: string }) {
  const live = useLive();
  const [problem, setProblem] = useState('');
  const [isBusy, setBusy] = useState(false);
  const left = session.leftEdits();
  const map = mapOfDraft(session.name);
  const move = async () => {
    setBusy(true);
    try {
      const { draft } = await mapEdits.createMapDraft({ parent: map, requestId: uuid(), draft: { displayName: session.state.displayName, author: author.get() } });
      for (let i = 0; i < left.length; i += 100) await mapEdits.appendMapEdits({ name: draft!.name, edits: left.slice(i, i + 100) });
      await session.outbox.discard();
      navigate(editAddress(live.id, map, draft!.name));
    } catch (error) {
      setProblem(refusalOf(error));
      setBusy(false);
    }
  };
  return (
    <div className="refusal" role="alert">
      <p>
        This draft takes no more edits: {reason}. {count(left.length, 'edit')} of yours {left.length === 1 ? 'is' : 'are'} not in it, but kept in this browser.
      </p>
      {left.length > 0 && (
        <div className="actions">
          {/* In another map they lie elsewhere. */}
          {session.mergedInto === undefined && (
            <button className="button" disabled={isBusy} onClick={() => void move()}>
              Put them into a new draft
            </button>
          )}
          <Sure title="Give them up" question="Give them up?" keep="Keep them" act="Give them up" busy={isBusy} onAct={() => void session.giveUp()} />
        </div>
      )}
      {problem !== '' && <p>{problem}</p>}
    </div>
  );
}

function Merged({ into }: { into: string }) {
  const live = useLive();
  return (
    <p className="refusal" role="alert">
      The map was merged into <Link href={editAddress(live.id, into)}>{titleOf(live, into)}</Link>. The draft goes on there.
    </p>
  );
}

// Whether the server has everything.
export function SyncState({ session }: { session: EditSession }) {
  const { state, pending, isDurable } = session.outbox;
  const { stream } = session;
  return (
    <div className="edit-sync">
      {state.kind === 'ended' && pending > 0 ? (
        <Left session={session} reason={state.reason} />
      ) : (
        <p role="status" data-pending={pending}>
          {pending === 0 ? <Badge tone="good">All edits are stored</Badge> : <Badge tone={state.kind === 'waiting' ? 'warn' : 'quiet'}>{count(pending, 'edit')} not stored yet</Badge>}
          {state.kind === 'waiting' && <Waiting reason={state.reason} retryAt={state.retryAt} />}
        </p>
      )}
      {pending > 0 && !isDurable && <p className="refusal">This browser keeps nothing: stay on this page until all edits are stored.</p>}
      {stream.kind === 'lost' && <p className="sub">The edits of others are not shown at the moment: {stream.reason}.</p>}
      {session.isDeleted && session.mergedInto === undefined && pending === 0 && <p className="refusal" role="alert">This draft was deleted.</p>}
      {session.mergedInto !== undefined && <Merged into={session.mergedInto} />}
      {session.refusals.map((reason, i) => (
        <p key={i} className="refusal" role="alert">
          The server does not take an edit, so it was taken back: {reason}
        </p>
      ))}
      {session.refusals.length > 0 && (
        <button className="button small-text" onClick={() => session.dismiss()}>
          I have read it
        </button>
      )}
    </div>
  );
}

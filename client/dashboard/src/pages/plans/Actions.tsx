// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useState } from 'react';
import { priorMaps } from '../../api/clients';
import { idOf } from '../../api/names';
import { addressOf, Link, navigate } from '../../app/router';
import { PriorMap_State, type PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import { useLive } from '../../live/context';
import { plansKey } from '../../live/plans';
import { refusalOf } from '../../ui/Sending';
import { answerOf, isAligned, isPicture, mayActivate, maySuspend, type Answer } from './plans';

// A second button, so that nothing is deleted by one click.
function Delete({ title, isInUse, busy, remove }: { title: string; isInUse: boolean; busy: boolean; remove: () => void }) {
  const [isAsking, setAsking] = useState(false);
  if (!isAsking) {
    return (
      <button className="button" disabled={busy} onClick={() => setAsking(true)}>
        Delete
      </button>
    );
  }
  return (
    <span className="plan-question" role="group" aria-label={`Delete ${title}?`}>
      {isInUse ? `“${title}” is in use: maps that only it places lose their place. ` : ''}Delete “{title}” and its file?
      <button className="button" autoFocus onClick={() => setAsking(false)}>
        Keep it
      </button>
      <button className="button plan-delete" disabled={busy} onClick={remove}>
        Delete it
      </button>
    </span>
  );
}

type Act = 'align' | 'again' | 'activate' | 'suspend' | 'delete';

async function act(what: Act, { name, etag, state }: PriorMap): Promise<Answer | undefined> {
  if (what === 'align' || what === 'again') return answerOf((await priorMaps.alignPriorMap({ name, etag, fromLast: what === 'again' })).priorMap!);
  if (what === 'activate') await priorMaps.activatePriorMap({ name, etag });
  else if (what === 'suspend') await priorMaps.suspendPriorMap({ name, etag });
  else await priorMaps.deletePriorMap({ name, etag, force: state === PriorMap_State.ACTIVE });
  return undefined;
}

// The etag is that of what the person sees: a plan that somebody else has changed meanwhile is left as it is.
export function Actions({ plan }: { plan: PriorMap }) {
  const live = useLive();
  const queries = useQueryClient();
  const { mutate, data, error, isPending, variables } = useMutation({
    mutationFn: (what: Act) => act(what, plan),
    onSettled: async (_answer, failure, what) => {
      if (what === 'delete' && !failure) navigate(addressOf(live.id, 'plans'), 'replace');
      await queries.invalidateQueries({ queryKey: plansKey(live.id) });
    },
  });
  return (
    <>
      <div className="plan-actions" role="group" aria-label="Actions">
        {plan.alignment && (
          <button className="button primary" disabled={isPending} title="Begin where it was placed last, and do not look elsewhere" onClick={() => mutate('again')}>
            Align again
          </button>
        )}
        <button className={plan.alignment ? 'button' : 'button primary'} disabled={isPending} onClick={() => mutate('align')}>
          Align
        </button>
        {isPicture(plan) && (
          <Link className="button" href={addressOf(live.id, 'plans', [idOf(plan.name), 'points'])}>
            Align by points
          </Link>
        )}
        <Link className="button" href={addressOf(live.id, 'plans', [idOf(plan.name), 'walls'])}>
          Correct walls
        </Link>
        {isAligned(plan) && (
          <Link className="button" href={addressOf(live.id, 'plans', [idOf(plan.name), 'compare'])}>
            Before and after
          </Link>
        )}
        <button className="button" disabled={isPending || !mayActivate(plan)} onClick={() => mutate('activate')}>
          Activate
        </button>
        <button className="button" disabled={isPending || !maySuspend(plan)} onClick={() => mutate('suspend')}>
          Suspend
        </button>
        <Delete title={plan.displayName} isInUse={plan.state === PriorMap_State.ACTIVE} busy={isPending} remove={() => mutate('delete')} />
      </div>
      {isPending && (variables === 'align' || variables === 'again') && <p role="status">Looking for the plan in the maps of its level …</p>}
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
      {data && <p className={data.isAccepted ? undefined : 'refusal'} role="status">{data.text}</p>}
    </>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useMutation } from '@tanstack/react-query';
import { useState } from 'react';
import { maps } from '../../../api/clients';
import { problemOf } from '../../../api/errors';
import { idOf } from '../../../api/names';
import { select } from '../../../app/selection';
import { planSplit, type Leaving } from '../../../graph/rearranging';
import type { Session } from '../../../gen/enfilade/v1/session_pb';
import { useLive } from '../../../live/context';
import { titleOf } from '../../../live/objects';
import { dateTime, shortened } from '../../../ui/format';
import { Failed, Loading } from '../../../ui/States';
import { Confirm } from '../../../ui/Confirm';
import { useSessionsOfSite } from './useSessions';

function Row({ session, leaving, set }: { session: Session; leaving: Leaving; set: (leaving: Leaving) => void }) {
  const name = `${idOf(session.robot)}, ${session.createTime ? dateTime(timestampMs(session.createTime)) : shortened(idOf(session.name))}`;
  const last = session.acknowledgedSequence;
  return (
    <li className="leaving">
      <label className="choice">
        {name}
        <select className="select" value={typeof leaving === 'bigint' ? 'cut' : leaving} onChange={({ target: { value } }) => set(value === 'cut' ? last / 2n + 1n : (value as 'stays' | 'leaves'))}>
          <option value="stays">stays</option>
          <option value="leaves">leaves</option>
          {last > 1n && <option value="cut">leaves from a record on</option>}
        </select>
      </label>
      {typeof leaving === 'bigint' && (
        <label className="choice">
          First record that leaves (2 to {String(last)})
          <input className="field" type="number" min={2} max={Number(last)} value={String(leaving)} onChange={({ target: { value } }) => /^\d+$/.test(value) && set(BigInt(value))} />
        </label>
      )}
    </li>
  );
}

// A map that is more than one room.
export function SplitForm({ map, done }: { map: string; done: () => void }) {
  const live = useLive();
  const [leaving, setLeaving] = useState<ReadonlyMap<string, Leaving>>(new Map());
  const { data, error, refetch } = useSessionsOfSite(live.id);
  const split = useMutation({
    mutationFn: () => maps.splitMap({
      name: map, sessions: [...leaving].flatMap(([name, part]) => (part === 'leaves' ? [name] : [])),
      cuts: [...leaving].flatMap(([session, part]) => (typeof part === 'bigint' ? [{ session, firstSequence: part }] : [])),
    }),
    onSuccess: (answer) => {
      if (answer.map) select(answer.map.name);
      done();
    },
  });
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading rows={3} />;
  const own = data.filter((session) => session.map === map);
  const plan = planSplit(map, own, leaving, (name) => titleOf(live, name));
  return (
    <Confirm title={`Split “${titleOf(live, map)}”?`} lines={plan.lines} refusal={plan.refusal} act="Split it" keep="Keep it whole" busy={split.isPending} onAct={() => split.mutate()} onKeep={done}>
      <ul aria-label="Sessions of the map">
        {own.map((session) => (
          <Row key={session.name} session={session} leaving={leaving.get(session.name) ?? 'stays'} set={(part) => setLeaving(new Map(leaving).set(session.name, part))} />
        ))}
      </ul>
      {split.isPending && <p role="status">Drawing the maps anew …</p>}
      {split.error && (
        <p className="refusal" role="alert">
          {problemOf(split.error).title}: {problemOf(split.error).text}
        </p>
      )}
    </Confirm>
  );
}

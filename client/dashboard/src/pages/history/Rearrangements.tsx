// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useState } from 'react';
import { maps } from '../../api/clients';
import { problemOf } from '../../api/errors';
import { idOf } from '../../api/names';
import type { Rearrangement } from '../../gen/enfilade/v1/rearrangement_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { DataTable, type Column } from '../../ui/DataTable';
import { count, dateTime, shortened } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';
import { Confirm } from '../../ui/Confirm';
import { rearrangementsKey, useRearrangements } from './rearrangements';

function whatOf({ mergedMaps, newMaps, movedSessions, cutSessions }: Rearrangement, title: (name: string) => string): string {
  const parts = mergedMaps.map(({ map, into }) => `${title(map)} into ${title(into)}`);
  if (newMaps.length > 0) parts.push(`new: ${newMaps.map(title).join(', ')}`);
  if (movedSessions.length > 0) parts.push(count(movedSessions.length, 'session'));
  if (cutSessions.length > 0) parts.push(`${cutSessions.length} cut`);
  return parts.join('; ');
}

function Undo({ rearrangement, done }: { rearrangement: Rearrangement; done: () => void }) {
  const live = useLive();
  const queries = useQueryClient();
  const undo = useMutation({
    mutationFn: () => maps.undoRearrangement({ name: rearrangement.name }),
    onSuccess: async () => {
      await queries.invalidateQueries({ queryKey: rearrangementsKey(live.id) });
      done();
    },
  });
  const links = rearrangement.changedLinkPoints.length + rearrangement.removedLinkPoints.length;
  const lines = [
    `Undone: ${whatOf(rearrangement, (name) => titleOf(live, name))}.`,
    `Maps, sessions${links > 0 ? ` and ${count(links, 'link point')}` : ''} are restored exactly as they were before.`,
    'If any of it has been changed since, nothing is undone, and the server names what.',
  ];
  return (
    <Confirm title="Undo this?" lines={lines} act="Undo it" keep="Leave it" busy={undo.isPending} onAct={() => undo.mutate()} onKeep={done}>
      {undo.error && (
        <p className="refusal" role="alert">
          {problemOf(undo.error).title}: {problemOf(undo.error).text}
        </p>
      )}
    </Confirm>
  );
}

const stateOf = ({ undoTime, undoExpired }: Rearrangement) => (undoTime ? `undone ${dateTime(timestampMs(undoTime))}` : undoExpired ? 'permanent' : 'in effect');

// How the site's maps were merged and split, also by the server itself.
export function Rearrangements() {
  const live = useLive();
  const [asked, setAsked] = useState<string>();
  const { data, error, refetch } = useRearrangements(live.id);
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (data.length === 0) return <Empty title="Nothing was merged or split">Choose a map on the campus while you edit the graph to merge it with another one, or to split it.</Empty>;
  const title = (name: string) => titleOf(live, name);
  const columns: Column<Rearrangement>[] = [
    { title: 'Time', order: ({ createTime }) => (createTime ? timestampMs(createTime) : 0), cell: ({ createTime }) => createTime && dateTime(timestampMs(createTime)) },
    { title: 'Who', order: ({ actor }) => actor, cell: ({ actor }) => actor || <span className="sub">unknown</span> },
    { title: 'What', cell: (one) => whatOf(one, title) },
    { title: 'Why', cell: ({ reason }) => reason },
    { title: 'State', order: stateOf, cell: stateOf },
    {
      title: 'Change',
      cell: (one) => !one.undoTime && !one.undoExpired && (
        <button className="button" aria-label={`Undo: ${whatOf(one, title)}`} onClick={() => setAsked(one.name)}>
          Undo …
        </button>
      ),
    },
  ];
  const rearrangement = data.find(({ name }) => name === asked);
  return (
    <>
      {rearrangement && <Undo key={rearrangement.name} rearrangement={rearrangement} done={() => setAsked(undefined)} />}
      <DataTable caption="Merges and splits" noun={['rearrangement', 'rearrangements']} rows={data} columns={columns} keyOf={({ name }) => name}
        textOf={(one) => `${shortened(idOf(one.name))} ${one.actor} ${one.reason} ${whatOf(one, title)}`} />
    </>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQuery } from '@tanstack/react-query';
import { collect, sessions } from '../../api/clients';
import { idOf } from '../../api/names';
import { Closure_State, type Closure } from '../../gen/enfilade/v1/closure_pb';
import { Badge } from '../../ui/Badge';
import { DataTable, type Column } from '../../ui/DataTable';
import { Failed, Loading } from '../../ui/States';
import { stateOfClosure } from './states';

const columns = (change: (closure: Closure) => void, busy: boolean): Column<Closure>[] => [
  { title: 'Number', number: true, order: ({ name }) => Number(idOf(name)), cell: ({ name }) => idOf(name) },
  {
    title: 'State', order: ({ state }) => state,
    cell: ({ state }) => <Badge tone={stateOfClosure[state][0]}>{stateOfClosure[state][1]}</Badge>,
  },
  { title: 'Submap', number: true, order: ({ submap }) => Number(submap), cell: ({ submap }) => String(submap) },
  { title: 'Keyframe', number: true, order: ({ node }) => Number(node), cell: ({ node }) => String(node) },
  { title: 'Score', number: true, order: ({ score }) => score, cell: ({ score }) => score.toFixed(2) },
  { title: 'Chi²', number: true, order: ({ chi2 }) => chi2, cell: ({ chi2 }) => (Number.isFinite(chi2) ? chi2.toFixed(1) : '–') },
  { title: 'Reason', cell: ({ reason }) => reason },
  {
    title: 'Change',
    cell: (closure) => closure.state !== Closure_State.REJECTED && (
      <button className="button" disabled={busy} aria-label={`${closure.state === Closure_State.SUSPENDED ? 'Resume' : 'Suspend'} closure ${idOf(closure.name)}`} onClick={() => change(closure)}>
        {closure.state === Closure_State.SUSPENDED ? 'Resume' : 'Suspend'}
      </button>
    ),
  },
];

export function Closures({ session }: { session: string }) {
  const { data, error, refetch } = useQuery({
    queryKey: ['closures', session],
    queryFn: () => collect(async (pageToken) => {
      const answer = await sessions.listClosures({ parent: session, pageSize: 1000, pageToken });
      return [answer.closures, answer.nextPageToken];
    }),
  });
  const change = useMutation({
    mutationFn: async ({ name, state }: Closure) => {
      if (state === Closure_State.SUSPENDED) await sessions.resumeClosure({ name });
      else await sessions.suspendClosure({ name });
    },
    onSettled: () => refetch(),
  });
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading rows={2} />;
  if (data.length === 0) return <p className="sub">None tried: the robot came to no place of this session again.</p>;
  return (
    <>
      {change.error && <Failed error={change.error} retry={() => change.reset()} />}
      <DataTable caption="Loop closures" noun={['closure', 'closures']} rows={data} columns={columns((closure) => change.mutate(closure), change.isPending)}
        keyOf={({ name }) => name} textOf={({ name, reason, state }) => `${idOf(name)} ${reason} ${stateOfClosure[state][1]}`} />
    </>
  );
}

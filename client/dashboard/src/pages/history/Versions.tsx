// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { graphs } from '../../api/clients';
import { siteName } from '../../api/names';
import { GraphVersion_Cause as Cause, type GraphVersion } from '../../gen/enfilade/v1/graph_pb';
import { useLive } from '../../live/context';
import { DataTable, type Column } from '../../ui/DataTable';
import { count, dateTime, shortened } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';

// The newest; older ones are for programs.
const SHOWN = 1000;

const causes: Record<Cause, string> = {
  [Cause.UNSPECIFIED]: 'Changed',
  [Cause.MAP_ADDED]: 'Map added',
  [Cause.MAP_CHANGED]: 'Map changed',
  [Cause.MAP_REMOVED]: 'Map removed',
  [Cause.LINK_POINT_ADDED]: 'Link point added',
  [Cause.LINK_POINT_CHANGED]: 'Link point changed',
  [Cause.LINK_POINT_REMOVED]: 'Link point removed',
  [Cause.OPTIMIZED]: 'Optimised',
  [Cause.GEOREFERENCED]: 'Georeferenced',
  [Cause.REARRANGED]: 'Maps merged or split',
};

// How well the link points agree, before and after an optimisation.
function agreement({ cause, chi2Before, chi2After, switchedOff }: GraphVersion): string {
  if (cause !== Cause.OPTIMIZED) return '–';
  const off = switchedOff.length > 0 ? `, ${count(switchedOff.length, 'link point')} switched off` : '';
  return `${chi2Before.toFixed(1)} → ${chi2After.toFixed(1)}${off}`;
}

const columns: Column<GraphVersion>[] = [
  { title: 'Version', number: true, order: ({ graphVersion }) => Number(graphVersion), cell: ({ graphVersion }) => String(graphVersion) },
  { title: 'Time', order: ({ createTime }) => (createTime ? timestampMs(createTime) : 0), cell: ({ createTime }) => createTime && dateTime(timestampMs(createTime)) },
  { title: 'What', order: ({ cause }) => causes[cause], cell: ({ cause }) => causes[cause] },
  { title: 'Of', cell: ({ resource }) => (resource === '' ? <span className="sub">the whole graph</span> : <span className="mono" title={resource}>{shortened(resource)}</span>) },
  { title: 'Who', order: ({ actor }) => actor, cell: ({ actor, cause }) => actor || <span className="sub">{cause === Cause.OPTIMIZED ? 'the server' : 'unknown'}</span> },
  { title: 'Chi-squared', cell: agreement },
];

export function Versions() {
  const live = useLive();
  const { data, error, refetch } = useQuery({
    queryKey: ['versions', live.id, String(live.graphVersion)],
    placeholderData: (earlier: GraphVersion[] | undefined) => earlier,
    queryFn: async () => (await graphs.listGraphVersions({ parent: siteName(live.id), pageSize: SHOWN })).graphVersions,
  });
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (data.length === 0) return <Empty title="No history yet">The graph of this site has not changed since it was made.</Empty>;
  return (
    <DataTable caption="Versions of the graph" noun={['version', 'versions']} rows={data} columns={columns} keyOf={({ graphVersion }) => String(graphVersion)}
      textOf={(version) => `${version.graphVersion} ${causes[version.cause]} ${version.resource} ${version.actor}`} />
  );
}

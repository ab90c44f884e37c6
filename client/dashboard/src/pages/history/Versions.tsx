// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { addressOf, Link } from '../../app/router';
import { GraphVersion_Cause as Cause, type GraphVersion } from '../../gen/enfilade/v1/graph_pb';
import { useLive } from '../../live/context';
import { DataTable, type Column } from '../../ui/DataTable';
import { dateTime, shortened } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';
import { agreement, placings, useVersions } from './placings';

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
  [Cause.PRIOR_MAP_CHANGED]: 'Plan changed',
};

// A version that placed the maps is a link to where they were.
function Version({ version }: { version: string }) {
  const live = useLive();
  return <Link href={addressOf(live.id, 'history', [], { at: version })}>{version}</Link>;
}

const columnsOf = (shown: Set<string>): Column<GraphVersion>[] => [
  {
    title: 'Version', number: true, order: ({ graphVersion }) => Number(graphVersion),
    cell: ({ graphVersion }) => (shown.has(String(graphVersion)) ? <Version version={String(graphVersion)} /> : String(graphVersion)),
  },
  { title: 'Time', order: ({ createTime }) => (createTime ? timestampMs(createTime) : 0), cell: ({ createTime }) => createTime && dateTime(timestampMs(createTime)) },
  { title: 'What', order: ({ cause }) => causes[cause], cell: ({ cause }) => causes[cause] },
  { title: 'Of', cell: ({ resource }) => (resource === '' ? <span className="sub">the whole graph</span> : <span className="mono" title={resource}>{shortened(resource)}</span>) },
  { title: 'Who', order: ({ actor }) => actor, cell: ({ actor, cause }) => actor || <span className="sub">{cause === Cause.OPTIMIZED ? 'the server' : 'unknown'}</span> },
  { title: 'Chi-squared', cell: agreement },
];

export function Versions() {
  const { data, error, refetch } = useVersions();
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (data.length === 0) return <Empty title="No history yet">The graph of this site has not changed since it was made.</Empty>;
  const shown = new Set(placings(data).map(({ graphVersion }) => String(graphVersion)));
  return (
    <DataTable caption="Versions of the graph" noun={['version', 'versions']} rows={data} columns={columnsOf(shown)} keyOf={({ graphVersion }) => String(graphVersion)}
      textOf={(version) => `${version.graphVersion} ${causes[version.cause]} ${version.resource} ${version.actor}`} />
  );
}

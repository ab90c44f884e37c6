// SPDX-License-Identifier: Apache-2.0
import { Fragment } from 'react';
import { idOf } from '../../api/names';
import { addressOf, Link, usePlace } from '../../app/router';
import { onCampus, useSelection } from '../../app/selection';
import type { GraphLinkPoint } from '../../gen/enfilade/v1/graph_pb';
import { useLive } from '../../live/context';
import { kindOf, stateOf, titleOf } from '../../live/objects';
import type { LiveSite } from '../../live/site';
import { Badge } from '../../ui/Badge';
import { DataTable, type Column } from '../../ui/DataTable';
import { byName, metres } from '../../ui/format';
import { Empty } from '../../ui/States';
import { Candidates } from './Candidates';

// The longer half axis of its 1-sigma ellipse in the world, m. The covariance is that of (x, y, yaw), row by row.
function sigmaOf({ poseWorldPlace }: GraphLinkPoint): number {
  const c = poseWorldPlace?.covariance;
  if (c?.length !== 9) return NaN;
  return Math.sqrt((c[0]! + c[4]!) / 2 + Math.hypot((c[0]! - c[4]!) / 2, c[1]!));
}

const mapsOf = (live: LiveSite, { maps }: GraphLinkPoint) => maps.map((map) => titleOf(live, map));

function columnsOf(live: LiveSite): Column<GraphLinkPoint>[] {
  return [
    {
      title: 'Link point',
      cell: ({ linkPoint, poseWorldPlace }) => {
        const id = idOf(linkPoint).slice(0, 8);
        return poseWorldPlace ? <Link className="mono" href={onCampus(live.id, linkPoint)} title={idOf(linkPoint)}>{id}</Link> : <span className="mono" title={idOf(linkPoint)}>{id}</span>;
      },
    },
    { title: 'Kind', order: kindOf, cell: kindOf },
    {
      title: 'State', order: (point) => stateOf(point).text,
      cell: (point) => {
        const { tone, text } = stateOf(point);
        return <Badge tone={tone}>{text}</Badge>;
      },
    },
    {
      title: 'Joins', order: (point) => mapsOf(live, point).join(' '),
      cell: ({ maps }) => maps.map((map, i) => (
        <Fragment key={map}>
          {i > 0 && ' – '}
          <Link href={addressOf(live.id, 'maps', [idOf(map)])}>{titleOf(live, map)}</Link>
        </Fragment>
      )),
    },
    { title: 'Sigma in the world', number: true, order: (point) => sigmaOf(point), cell: (point) => metres(sigmaOf(point)) },
  ];
}

// From the stream: it is current without being read again.
function AllLinkPoints() {
  const live = useLive();
  const selected = useSelection();
  const joins = (point: GraphLinkPoint) => mapsOf(live, point).join(' ');
  const rows = [...live.linkPoints.values()].sort((a, b) => byName(joins(a), joins(b)));
  if (rows.length === 0) {
    return (
      <Empty title="No link points yet" command={`enfilade --site ${live.id} robot --robot r1 --campus figure1 --map Hall`}>
        A link point is a door, lift or ramp at which two maps meet. Robots find them while they drive; the command drives a
        simulated one.
      </Empty>
    );
  }
  return (
    <DataTable caption="Link points" noun={['link point', 'link points']} rows={rows} columns={columnsOf(live)} keyOf={({ linkPoint }) => linkPoint}
      textOf={(point) => `${idOf(point.linkPoint)} ${kindOf(point)} ${stateOf(point).text} ${mapsOf(live, point).join(' ')}`} selected={selected} />
  );
}

const tabs = [['', 'All'], ['candidates', 'Candidates']] as const;

export default function LinkPointsPage() {
  const live = useLive();
  const { rest } = usePlace();
  const shown = rest[0] ?? '';
  return (
    <div className="page">
      <div className="page-head">
        <h1>Link points</h1>
        <nav className="tabs" aria-label="Kinds of link points">
          {tabs.map(([path, title]) => (
            <Link key={path} className="button" href={addressOf(live.id, 'linkPoints', path === '' ? [] : [path])} aria-current={path === shown ? 'page' : undefined}>
              {title}
            </Link>
          ))}
        </nav>
      </div>
      {shown === 'candidates' ? <Candidates /> : <AllLinkPoints />}
    </div>
  );
}

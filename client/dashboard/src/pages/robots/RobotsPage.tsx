// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { collect, robots } from '../../api/clients';
import { idOf, siteName } from '../../api/names';
import { addressOf, Link, usePlace } from '../../app/router';
import { onCampus, useSelection } from '../../app/selection';
import { useLive, useNow } from '../../live/context';
import { titleOf } from '../../live/objects';
import type { LiveRobot } from '../../live/robots';
import { Badge } from '../../ui/Badge';
import { DataTable, type Column } from '../../ui/DataTable';
import { age, byName, metres } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';
import { STALE_S } from '../campus/ObjectList';
import { RobotPage } from './RobotPage';

interface Row {
  name: string;
  title: string;
  live: LiveRobot | undefined;
  // Seconds since its last pose; Infinity: it has told none.
  age: number;
  // The longer half axis of its 1-sigma ellipse, m.
  sigma: number;
}

function sigmaOf([xx, xy, yy]: LiveRobot['covariance']): number {
  return Math.sqrt((xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy));
}

function State({ row }: { row: Row }) {
  if (!row.live) return <Badge tone="quiet">No pose yet</Badge>;
  if (row.age > STALE_S) return <Badge tone="quiet">No longer reports</Badge>;
  if (!row.live.poseWorld) return <Badge tone="warn">Its map is not joined</Badge>;
  return <Badge tone="good">Reports its pose</Badge>;
}

function columnsOf(live: ReturnType<typeof useLive>): Column<Row>[] {
  return [
    {
      title: 'Robot', order: ({ title }) => title,
      cell: ({ name, title }) => <Link href={addressOf(live.id, 'robots', [idOf(name)])}>{title}</Link>,
    },
    { title: 'State', order: (row) => row.age, cell: (row) => <State row={row} /> },
    {
      title: 'Map', order: ({ live: robot }) => (robot ? titleOf(live, robot.map) : ''),
      cell: ({ live: robot }) => robot && <Link href={addressOf(live.id, 'maps', [idOf(robot.map)])}>{titleOf(live, robot.map)}</Link>,
    },
    {
      title: 'Revision', number: true,
      cell: ({ live: robot }) => {
        const raster = robot && live.rasters.get(robot.map);
        return raster ? idOf(raster.revision) : '–';
      },
    },
    { title: 'Last pose', number: true, order: (row) => row.age, cell: (row) => (row.live ? `${age(row.age)} ago` : '–') },
    { title: 'Sigma', number: true, order: ({ sigma }) => sigma, cell: ({ sigma }) => metres(sigma) },
    {
      title: 'Session',
      cell: ({ live: robot }) => robot?.session && (
        <Link className="mono" href={addressOf(live.id, 'sessions', [idOf(robot.session)])}>
          {idOf(robot.session).slice(0, 8)}
        </Link>
      ),
    },
    { title: 'Campus', cell: ({ name, title, live: robot }) => robot?.poseWorld && <Link href={onCampus(live.id, name, robot.level)} aria-label={`Show ${title} on the campus`}>Show</Link> },
  ];
}

function Robots() {
  const live = useLive();
  const now = useNow();
  const selected = useSelection();
  const { data, error, refetch } = useQuery({
    queryKey: ['robots', live.id],
    queryFn: () => collect(async (pageToken) => {
      const answer = await robots.listRobots({ parent: siteName(live.id), pageSize: 1000, pageToken });
      return [answer.robots, answer.nextPageToken];
    }),
  });
  const unsorted = (data ?? []).map(({ name, displayName }): Row => {
    const robot = live.robots.get(name);
    return {
      name, title: displayName || idOf(name), live: robot,
      age: robot ? live.ageOf(robot.receiveTime, now) : Infinity, sigma: robot ? sigmaOf(robot.covariance) : NaN,
    };
  });
  const rows = unsorted.sort((a, b) => byName(a.title, b.title));
  return (
    <>
      {error && !data ? (
        <Failed error={error} retry={() => void refetch()} />
      ) : !data ? (
        <Loading />
      ) : rows.length === 0 ? (
        <Empty title="No robots yet" command={`enfilade --site ${live.id} robot --robot r1 --campus figure1 --map Hall`}>
          A robot appears here when it begins its first session. The command drives a simulated one.
        </Empty>
      ) : (
        <DataTable caption="Robots" noun={['robot', 'robots']} rows={rows} columns={columnsOf(live)} keyOf={({ name }) => name}
          textOf={({ name, title, live: robot }) => `${title} ${idOf(name)} ${robot ? titleOf(live, robot.map) : ''}`} selected={selected} />
      )}
    </>
  );
}

export default function RobotsPage() {
  const { rest } = usePlace();
  if (rest[0] !== undefined) return <RobotPage id={rest[0]} />;
  return (
    <div className="page">
      <div className="page-head">
        <h1>Robots</h1>
      </div>
      <Robots />
    </div>
  );
}

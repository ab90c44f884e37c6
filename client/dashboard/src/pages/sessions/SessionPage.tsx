// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { sessions } from '../../api/clients';
import { idOf, siteName } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { Session_State, type Session } from '../../gen/enfilade/v1/session_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { Badge } from '../../ui/Badge';
import { dateTime, perSecond } from '../../ui/format';
import { Failed, Loading } from '../../ui/States';
import { Closures } from './Closures';
import { stateOfSession } from './states';
import { TrajectoryView } from './TrajectoryView';
import { Verdicts } from './Verdicts';

function Facts({ session }: { session: Session }) {
  const live = useLive();
  // The stream knows more of a session that goes on.
  const { state, map, acknowledgedSequence, mappedSequence, error } = live.sessions.get(session.name) ?? session;
  const [tone, text] = stateOfSession[state];
  const counts = session.recordCounts;
  const mapping = session.mappingCounts;
  return (
    <dl className="facts card padded">
      <dt>State</dt>
      <dd>
        <Badge tone={tone}>{text}</Badge>
      </dd>
      {error !== '' && (
        <>
          <dt>Reason</dt>
          <dd>{error}</dd>
        </>
      )}
      <dt>Robot</dt>
      <dd>
        <Link href={addressOf(live.id, 'robots', [idOf(session.robot)])}>{idOf(session.robot)}</Link>
      </dd>
      <dt>Map</dt>
      <dd>{map === '' ? 'not decided yet' : <Link href={addressOf(live.id, 'maps', [idOf(map)])}>{titleOf(live, map)}</Link>}</dd>
      <dt>Begun</dt>
      <dd>{session.createTime && dateTime(timestampMs(session.createTime))}</dd>
      {session.finishTime && (
        <>
          <dt>Finished</dt>
          <dd>{dateTime(timestampMs(session.finishTime))}</dd>
        </>
      )}
      <dt>Records</dt>
      <dd>
        {String(acknowledgedSequence)} stored, {String(mappedSequence)} of them mapped
        {state === Session_State.RECORDING && <span className="sub"> · {perSecond(live.recordRate(session.name))}</span>}
      </dd>
      {counts && (
        <>
          <dt>Contents</dt>
          <dd>
            {String(counts.laserScans)} scans, {String(counts.odometries)} odometry readings, {String(counts.images)} images,{' '}
            {String(counts.pointClouds)} point clouds
          </dd>
        </>
      )}
      {mapping && (
        <>
          <dt>Scans in the map</dt>
          <dd>
            {String(mapping.used)} used, {String(mapping.keyframes)} keyframes, {String(mapping.lost)} lost
          </dd>
        </>
      )}
    </dl>
  );
}

export function SessionPage({ id }: { id: string }) {
  const live = useLive();
  const name = `${siteName(live.id)}/sessions/${id}`;
  const { data, error, refetch } = useQuery({
    queryKey: ['session', name, live.sessions.get(name)?.state],
    placeholderData: (earlier: Session | undefined) => (earlier?.name === name ? earlier : undefined),
    queryFn: async () => (await sessions.getSession({ name })).session,
  });
  return (
    <div className="page">
      <div className="page-head">
        <h1>
          <Link href={addressOf(live.id, 'sessions')}>Sessions</Link> / <span className="mono">{id.slice(0, 8)}</span>
        </h1>
        <span className="space" />
        {data && (
          <a className="button" href={`/v1/${name}/trajectory.csv`} download>
            Trajectory (CSV)
          </a>
        )}
      </div>
      {error && !data ? (
        <Failed error={error} retry={() => void refetch()} />
      ) : !data ? (
        <Loading />
      ) : (
        <>
          <div className="session-top">
            <Facts session={data} />
            <TrajectoryView key={name} session={data} />
          </div>
          <h2>Doors that the robot passed</h2>
          <Verdicts session={name} />
          <h2>Loop closures</h2>
          <Closures session={name} />
        </>
      )}
    </div>
  );
}

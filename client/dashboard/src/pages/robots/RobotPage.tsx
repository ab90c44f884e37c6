// SPDX-License-Identifier: Apache-2.0
import './robot.css';
import { useQuery } from '@tanstack/react-query';
import { useMemo, useRef, useState } from 'react';
import { robots } from '../../api/clients';
import { idOf, withSite } from '../../api/names';
import { addressOf, Link, navigate } from '../../app/router';
import { onCampus } from '../../app/selection';
import { useLive } from '../../live/context';
import type { LiveRobot } from '../../live/robots';
import type { View } from '../../scene/model';
import { SceneView, ToolButton } from '../../scene/SceneView';
import { Failed, Loading } from '../../ui/States';
import { HowKnown } from '../campus/HowKnown';
import { Readout, type ReadoutHandle } from '../campus/Readout';
import { SessionTable, useSessions } from '../sessions/SessionTable';
import { RobotFacts } from './RobotFacts';
import { Timeline } from './Timeline';

// Where it is, kept in the middle until somebody moves the picture. A robot whose map has no place is shown in that map.
function RobotView({ robot }: { robot: LiveRobot }) {
  const readout = useRef<ReadoutHandle>(null);
  const [follow, setFollow] = useState(true);
  const placed = robot.poseWorld !== undefined;
  const view = useMemo<View>(() => ({
    selected: robot.name, follow, trails: true, ...(placed ? { level: robot.level } : { map: robot.map }),
  }), [robot.name, robot.map, robot.level, placed, follow]);
  return (
    <SceneView view={view} events={{ hover: (...at) => readout.current?.hover(...at), taken: () => setFollow(false) }} tools={
      <ToolButton icon="follow" title="Keep the robot in the middle" pressed={follow} onClick={() => setFollow(!follow)} />
    }>
      <Readout ref={readout} said="" />
    </SceneView>
  );
}

function Sessions({ robot }: { robot: string }) {
  const { data, error, refetch } = useSessions();
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  const own = data.filter((session) => session.robot === robot);
  if (own.length === 0) return <p className="sub">None that are kept.</p>;
  return (
    <>
      <Timeline sessions={own} />
      <SessionTable rows={own} />
    </>
  );
}

export function RobotPage({ id }: { id: string }) {
  const live = useLive();
  const name = withSite(live.id, `robots/${id}`);
  const robot = live.robots.get(name);
  const { data, error, refetch } = useQuery({ queryKey: ['robot', name], queryFn: async () => (await robots.getRobot({ name })).robot });
  const goTo = (what: string) => navigate(onCampus(live.id, what, live.maps.get(what)?.level));
  return (
    <div className="page">
      <div className="page-head">
        <h1>
          <Link href={addressOf(live.id, 'robots')}>Robots</Link> / {data?.displayName || idOf(name)}
        </h1>
        <span className="space" />
        {robot?.poseWorld && (
          <Link className="button" href={onCampus(live.id, name, robot.level)}>
            Show on the campus
          </Link>
        )}
      </div>
      {error && !data ? (
        <Failed error={error} retry={() => void refetch()} />
      ) : !data ? (
        <Loading />
      ) : (
        <>
          {robot ? (
            <div className="robot-top">
              <section className="card robot-facts" aria-label="The robot now">
                <RobotFacts robot={robot} openMap={(map) => navigate(addressOf(live.id, 'maps', [idOf(map)]))} />
                <HowKnown name={name} choose={goTo} />
              </section>
              <section className="card robot-view" aria-label="Where the robot is">
                <RobotView robot={robot} />
              </section>
            </div>
          ) : (
            <p className="sub">It has reported no pose yet. A robot reports where it is when it drives with Enfilade’s client, or by the call ReportRobotPose.</p>
          )}
          <h2>Sessions</h2>
          <Sessions robot={name} />
        </>
      )}
    </div>
  );
}

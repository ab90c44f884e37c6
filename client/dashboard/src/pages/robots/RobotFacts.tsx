// SPDX-License-Identifier: Apache-2.0
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { WorldPose } from '../../geo/WorldPose';
import { useLive, useNow } from '../../live/context';
import { titleOf } from '../../live/objects';
import type { LiveRobot } from '../../live/robots';
import { Badge } from '../../ui/Badge';
import { age, clock, levelName, pose as poseText } from '../../ui/format';
import { STALE_S } from '../campus/ObjectList';
import { sigma } from '../campus/Readout';

// `openMap`: what a click at its map does.
export function RobotFacts({ robot, openMap }: { robot: LiveRobot; openMap: (map: string) => void }) {
  const site = useLive();
  const now = useNow();
  const seconds = site.ageOf(robot.receiveTime, now);
  return (
    <dl className="facts">
      <dt>Last report</dt>
      <dd>
        <Badge tone={seconds > STALE_S ? 'quiet' : 'good'}>
          {seconds > STALE_S ? `${age(seconds)} ago, at ${clock(robot.receiveTime + site.clockOffset)}` : 'now'}
        </Badge>
      </dd>
      <dt>In the world</dt>
      {robot.poseWorld ? <WorldPose pose={robot.poseWorld} /> : <dd>not known</dd>}
      <dt>In the map</dt>
      <dd>{poseText(robot.poseMap)}</dd>
      <dt>Uncertainty (1 σ)</dt>
      <dd>{sigma(robot.covariance)}</dd>
      <dt>Map</dt>
      <dd>
        <button className="share-name" onClick={() => openMap(robot.map)}>
          {titleOf(site, robot.map)}
        </button>
        , {levelName(robot.level).toLowerCase()}
      </dd>
      {robot.session !== '' && (
        <>
          <dt>Session</dt>
          <dd>
            <Link className="mono" href={addressOf(site.id, 'sessions', [idOf(robot.session)])} title={idOf(robot.session)}>
              {idOf(robot.session).slice(0, 8)}
            </Link>
          </dd>
        </>
      )}
    </dl>
  );
}

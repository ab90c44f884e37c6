// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import type { ReactNode } from 'react';
import { graphs } from '../../api/clients';
import { collectionOf, idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { select } from '../../app/selection';
import type { GlobalPose, GraphLinkPoint, GraphMap } from '../../gen/enfilade/v1/graph_pb';
import { converterOf, useGeoreference } from '../../geo/georeference';
import { OnTheGlobe } from '../../geo/OnTheGlobe';
import { useLive, useNow } from '../../live/context';
import { kindOf, stateOf, titleOf } from '../../live/objects';
import type { LiveRobot } from '../../live/robots';
import type { LiveSite } from '../../live/site';
import { unplacedOf } from '../../live/unplaced';
import { Badge } from '../../ui/Badge';
import { CopyButton } from '../../ui/CopyButton';
import { age, clock, levelName, pose as poseText } from '../../ui/format';
import { Icon, type IconName } from '../../ui/Icon';
import { Failed, Loading } from '../../ui/States';
import { sharesOf } from './explanation';
import { STALE_S } from './ObjectList';
import { sigma } from './Readout';

// How a robot, or the origin of a map, comes to its place; asked again while the robot moves.
export function useGlobalPose(site: LiveSite, name: string | undefined) {
  const kind = name === undefined ? '' : collectionOf(name);
  const robot = kind === 'robots';
  return useQuery({
    queryKey: ['globalPose', name, String(site.graphVersion)],
    enabled: robot ? site.robots.get(name!) !== undefined : kind === 'maps' && site.maps.get(name!)?.poseWorldMap !== undefined,
    refetchInterval: robot ? 2000 : false,
    placeholderData: (previous: GlobalPose | undefined) => previous,
    queryFn: async () => {
      const subject = robot
        ? { case: 'robot' as const, value: name! }
        : { case: 'mapPose' as const, value: { map: name!, poseMapRobot: { pose: {} } } };
      return (await graphs.getGlobalPose({ subject })).globalPose;
    },
  });
}

const percent = (part: number) => (part > 0 && part < 0.005 ? '< 1 %' : `${Math.round(part * 100)} %`);

function Explanation({ pose }: { pose: GlobalPose }) {
  const site = useLive();
  if (!pose.poseWorldRobot) {
    return <p className="sub">No link points join “{titleOf(site, pose.mapPose?.map ?? '')}” to the root, so that it has no place in the world.</p>;
  }
  return (
    <ol className="shares">
      {sharesOf(site, pose).map(({ title, name, variance, part }, i) => (
        <li key={`${name}-${i}`}>
          <div className="share-head">
            {name !== '' && collectionOf(name) !== 'robots' ? (
              <button className="share-name" onClick={() => select(name)}>
                {title}
              </button>
            ) : (
              <span>{title}</span>
            )}
            <span className="sub">
              {(Math.sqrt(variance) * 100).toFixed(1)} cm · {percent(part)}
            </span>
          </div>
          <div className="share-bar">
            <div className="share-fill" style={{ width: `${100 * part}%` }} />
          </div>
        </li>
      ))}
    </ol>
  );
}

function ExplanationOf({ name }: { name: string }) {
  const site = useLive();
  const { data, error, isPending, fetchStatus, refetch } = useGlobalPose(site, name);
  return (
    <section className="inspector-part">
      <h2>How this place is known</h2>
      {data ? <Explanation pose={data} /> : error ? <Failed error={error} retry={() => void refetch()} /> : isPending && fetchStatus !== 'idle' ? <Loading rows={3} /> : <p className="sub">Not joined to the root: it has no place in the world.</p>}
      {data?.poseWorldRobot && <p className="sub">Share of the position uncertainty by each step from the root. Graph version {String(data.graphVersion)}.</p>}
    </section>
  );
}

function Head({ icon, kind, title, actions }: { icon: IconName; kind: string; title: string; actions?: ReactNode }) {
  return (
    <div className="inspector-head">
      <Icon name={icon} />
      <div className="inspector-title">
        <h1>{title}</h1>
        <span className="sub">{kind}</span>
      </div>
      {actions}
      <button className="button icon plain" aria-label="Close" title="Close (Esc)" onClick={() => select(undefined)}>
        <Icon name="close" />
      </button>
    </div>
  );
}

// In the world, and on the globe if the site has a georeference.
function WorldPose({ pose }: { pose: { x: number; y: number; yaw: number } }) {
  const site = useLive();
  const { data } = useGeoreference(site);
  const place = converterOf(site, data)?.(pose);
  return (
    <>
      <dd className="with-action">
        {poseText(pose)}
        <CopyButton text={`${pose.x} ${pose.y} ${pose.yaw}`} what="x y yaw (m, rad)" />
      </dd>
      {place && <OnTheGlobe place={place} />}
    </>
  );
}

function RobotFacts({ robot }: { robot: LiveRobot }) {
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
        <button className="share-name" onClick={() => select(robot.map)}>
          {titleOf(site, robot.map)}
        </button>
        , {levelName(robot.level).toLowerCase()}
      </dd>
      {robot.session !== '' && (
        <>
          <dt>Session</dt>
          <dd className="mono">{idOf(robot.session)}</dd>
        </>
      )}
    </dl>
  );
}

function MapFacts({ map }: { map: GraphMap }) {
  const site = useLive();
  const raster = site.rasters.get(map.map);
  const c = map.poseWorldMap?.covariance ?? [];
  return (
    <dl className="facts">
      <dt>Level</dt>
      <dd>{levelName(map.level)}</dd>
      <dt>Frame in the world</dt>
      {map.poseWorldMap?.pose ? <WorldPose pose={map.poseWorldMap.pose} /> : <dd>{unplacedOf(site, undefined).find(({ name }) => name === map.map)?.reason}</dd>}
      {c.length === 9 && map.map !== site.rootMap && (
        <>
          <dt>Uncertainty (1 σ)</dt>
          <dd>{sigma([c[0]!, c[1]!, c[4]!, c[8]!])}</dd>
        </>
      )}
      <dt>Newest revision</dt>
      <dd>{raster ? `${idOf(raster.revision)}, ${clock(raster.createTime)}` : 'none yet: nothing has been mapped or imported'}</dd>
      <dt>Link points</dt>
      <dd>{[...site.linkPoints.values()].filter((point) => point.maps.includes(map.map)).length}</dd>
    </dl>
  );
}

function LinkFacts({ point }: { point: GraphLinkPoint }) {
  const site = useLive();
  const { tone, text } = stateOf(point);
  const pose = point.poseWorldPlace?.pose;
  const c = point.poseWorldPlace?.covariance ?? [];
  return (
    <dl className="facts">
      <dt>Id</dt>
      <dd className="mono">{idOf(point.linkPoint)}</dd>
      <dt>State</dt>
      <dd>
        <Badge tone={tone}>{text}</Badge>
      </dd>
      <dt>In the world</dt>
      {pose ? <WorldPose pose={pose} /> : <dd>not known: its maps are not joined to the root</dd>}
      {c.length === 9 && (
        <>
          <dt>Uncertainty (1 σ)</dt>
          <dd>{sigma([c[0]!, c[1]!, c[4]!, c[8]!])}</dd>
        </>
      )}
      <dt>{point.maps.length < 2 ? 'Seen from' : 'Joins'}</dt>
      <dd>
        {point.maps.map((map) => (
          <div key={map}>
            <button className="share-name" onClick={() => select(map)}>
              {titleOf(site, map)}
            </button>
          </div>
        ))}
      </dd>
    </dl>
  );
}

// What is selected: what it is, where it is, how that is known.
export function Inspector({ name, follow, setFollow }: { name: string; follow: boolean; setFollow: (on: boolean) => void }) {
  const site = useLive();
  const robot = site.robots.get(name);
  const map = site.maps.get(name);
  const point = site.linkPoints.get(name);
  if (robot) {
    return (
      <section className="inspector" aria-label="Selection">
        <Head icon="robot" kind="Robot" title={idOf(name)} actions={
          <button className="button" aria-pressed={follow} aria-keyshortcuts="f" title="Keep it in the middle (F)" onClick={() => setFollow(!follow)} disabled={!robot.poseWorld}>
            <Icon name="follow" /> Follow
          </button>
        } />
        <RobotFacts robot={robot} />
        <ExplanationOf name={name} />
      </section>
    );
  }
  if (map) {
    return (
      <section className="inspector" aria-label="Selection">
        <Head icon="map" kind="Map" title={map.displayName} actions={<Link className="button" href={addressOf(site.id, 'maps', [idOf(name)])}>Open</Link>} />
        <MapFacts map={map} />
        <ExplanationOf name={name} />
      </section>
    );
  }
  if (point) {
    return (
      <section className="inspector" aria-label="Selection">
        <Head icon="link" kind={kindOf(point)} title={point.maps.map((map) => titleOf(site, map)).join(' – ')} />
        <LinkFacts point={point} />
      </section>
    );
  }
  return (
    <section className="inspector" aria-label="Selection">
      <Head icon="search" kind={collectionOf(name)} title={idOf(name)} />
      <p className="sub">This site has no such thing now. It may have been deleted, or a robot may not have reported a pose yet.</p>
    </section>
  );
}

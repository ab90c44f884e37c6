// SPDX-License-Identifier: Apache-2.0
import type { ReactNode } from 'react';
import { collectionOf, idOf } from '../../api/names';
import { addressOf, Link, setQuery } from '../../app/router';
import { select } from '../../app/selection';
import type { GraphLinkPoint, GraphMap } from '../../gen/enfilade/v1/graph_pb';
import { WorldPose } from '../../geo/WorldPose';
import { useLive } from '../../live/context';
import { kindOf, stateOf, titleOf } from '../../live/objects';
import { unplacedOf } from '../../live/unplaced';
import { Badge } from '../../ui/Badge';
import { clock, levelName } from '../../ui/format';
import { Icon, type IconName } from '../../ui/Icon';
import { RobotFacts } from '../robots/RobotFacts';
import { HowKnown } from './HowKnown';
import { sigma } from './Readout';

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
        <Head icon="robot" kind="Robot" title={idOf(name)} actions={<>
          <Link className="button" href={addressOf(site.id, 'robots', [idOf(name)])}>Open</Link>
          <button className="button" aria-pressed={follow} aria-keyshortcuts="f" title="Keep it in the middle (F)" onClick={() => setFollow(!follow)} disabled={!robot.poseWorld}>
            <Icon name="follow" /> Follow
          </button>
        </>} />
        <RobotFacts robot={robot} openMap={select} />
        <HowKnown name={name} choose={select} />
      </section>
    );
  }
  if (map) {
    return (
      <section className="inspector" aria-label="Selection">
        <Head icon="map" kind="Map" title={map.displayName} actions={<Link className="button" href={addressOf(site.id, 'maps', [idOf(name)])}>Open</Link>} />
        <MapFacts map={map} />
        <HowKnown name={name} choose={select} />
      </section>
    );
  }
  if (point) {
    return (
      <section className="inspector" aria-label="Selection">
        <Head icon="link" kind={kindOf(point)} title={point.maps.map((map) => titleOf(site, map)).join(' – ')} actions={<button className="button" onClick={() => setQuery({ edit: 'graph' })}>Edit</button>} />
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

// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { graphs } from '../../api/clients';
import { collectionOf } from '../../api/names';
import type { GlobalPose } from '../../gen/enfilade/v1/graph_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import type { LiveSite } from '../../live/site';
import { Failed, Loading } from '../../ui/States';
import { sharesOf } from './explanation';

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

function Explanation({ pose, choose }: { pose: GlobalPose; choose: (name: string) => void }) {
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
              <button className="share-name" onClick={() => choose(name)}>
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

// `choose`: what a click at a step of the chain does.
export function HowKnown({ name, choose }: { name: string; choose: (name: string) => void }) {
  const site = useLive();
  const { data, error, isPending, fetchStatus, refetch } = useGlobalPose(site, name);
  return (
    <section className="inspector-part">
      <h2>How this place is known</h2>
      {data ? <Explanation pose={data} choose={choose} /> : error ? <Failed error={error} retry={() => void refetch()} /> : isPending && fetchStatus !== 'idle' ? <Loading rows={3} /> : <p className="sub">Not joined to the root: it has no place in the world.</p>}
      {data?.poseWorldRobot && <p className="sub">Share of the position uncertainty by each step from the root. Graph version {String(data.graphVersion)}.</p>}
    </section>
  );
}

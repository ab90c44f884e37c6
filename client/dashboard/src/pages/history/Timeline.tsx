// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useEffect, useMemo, useRef, useState } from 'react';
import { addressOf, Link, setQuery, usePlace } from '../../app/router';
import { select, useLevel, useSelection } from '../../app/selection';
import type { GraphVersion } from '../../gen/enfilade/v1/graph_pb';
import { useLive } from '../../live/context';
import type { View } from '../../scene/model';
import { stretchFor } from '../../scene/moves';
import { SceneView } from '../../scene/SceneView';
import { sharedScene, useThumbnails } from '../../scene/shared';
import { dateTime } from '../../ui/format';
import { Player } from '../../ui/Player';
import { Empty, Failed, Loading } from '../../ui/States';
import { Readout, type ReadoutHandle } from '../campus/Readout';
import { Difference } from './Difference';
import { differenceOf, type Places } from './movement';
import { placings, usePlaces, useVersions } from './placings';

const STEP_MS = 1000;

const none: Places = new Map();

const textOf = ({ graphVersion, createTime }: GraphVersion) => `Version ${graphVersion}${createTime ? `, ${dateTime(timestampMs(createTime))}` : ''}`;

// One step a second, from the oldest if it stood at the newest.
function usePlay(at: number, last: number, show: (index: number) => void) {
  const [playing, setPlaying] = useState(false);
  const next = useRef(() => {});
  next.current = () => (at < last ? show(at + 1) : setPlaying(false));
  useEffect(() => {
    if (!playing) return;
    const timer = setInterval(() => next.current(), STEP_MS);
    return () => clearInterval(timer);
  }, [playing]);
  const set = (on: boolean) => {
    if (on && at === last) show(0);
    setPlaying(on);
  };
  return { playing: playing && at < last, setPlaying: set };
}

// The maps where they were after each optimisation, and how they have moved since another one.
function Placings({ versions }: { versions: GraphVersion[] }) {
  const live = useLive();
  const level = useLevel();
  const selected = useSelection();
  const { query } = usePlace();
  const readout = useRef<ReadoutHandle>(null);
  const thumbnails = useThumbnails();
  const [wanted, setWanted] = useState<number>();

  const last = versions.length - 1;
  const indexOf = (text: string | null) => versions.findIndex(({ graphVersion }) => String(graphVersion) === text);
  const asked = indexOf(query.get('at'));
  const at = asked < 0 ? last : asked;
  const found = indexOf(query.get('from'));
  const compared = found >= 0 ? found : at - 1;
  const shown = versions[at]!;
  const other = compared === at ? undefined : versions[compared];
  const show = (index: number) => setQuery({ at: String(versions[index]!.graphVersion) });
  const { playing, setPlaying } = usePlay(at, last, show);

  const after = usePlaces(live.id, shown.graphVersion);
  const before = usePlaces(live.id, other?.graphVersion);
  const isSettled = !after.isPlaceholderData && !before.isPlaceholderData;
  const difference = useMemo(
    () => (other && isSettled && before.data && after.data ? differenceOf(before.data, after.data, thumbnails) : undefined),
    [other, isSettled, before.data, after.data, thumbnails],
  );
  const longest = difference?.moved[0]?.distance ?? 0;
  const bounds = longest > 0 ? sharedScene()?.extent() : undefined;
  const stretch = wanted ?? (bounds ? stretchFor(longest, bounds) : 1);
  const places = after.data ?? none;
  const view = useMemo<View>(() => ({ level, selected, places, moves: difference?.moved, stretch }), [level, selected, places, difference, stretch]);
  const error = after.error ?? before.error;
  return (
    <div className="campus">
      <div className="replayed">
        <SceneView view={view} events={{ hover: (...over) => readout.current?.hover(...over), click: (what) => select(what) }}>
          <Readout ref={readout} said="" />
        </SceneView>
        <Player label="Version of the graph" text={textOf(shown)} value={at} max={last} step={1} onChange={show} playing={playing} setPlaying={setPlaying} />
      </div>
      <aside className="panel" aria-label="Details">
        {query.get('at') !== null && asked < 0 && (
          <p className="sub" role="status">
            Version {query.get('at')} is no optimisation, or one that is no longer kept. This is the newest one.
          </p>
        )}
        {error ? (
          <Failed error={error} retry={() => void Promise.all([after.refetch(), before.refetch()])} />
        ) : (
          <Difference versions={versions} shown={shown} other={other} difference={difference} count={places.size} stretch={stretch} setStretch={setWanted} />
        )}
      </aside>
    </div>
  );
}

export function Timeline() {
  const live = useLive();
  const { data, error, refetch } = useVersions();
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data || !live.complete) return <Loading />;
  const versions = placings(data);
  if (versions.length === 0) {
    return (
      <Empty title="The maps have not been placed yet">
        The server places the maps of a site each time that its link points change. Then this page shows where they were after each
        of the last 50 times. <Link href={addressOf(live.id, 'history', ['versions'])}>All changes of the graph</Link>
      </Empty>
    );
  }
  return <Placings versions={versions} />;
}

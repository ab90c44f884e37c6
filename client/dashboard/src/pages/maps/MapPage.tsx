// SPDX-License-Identifier: Apache-2.0
import './map.css';
import { useQuery } from '@tanstack/react-query';
import { useEffect, useMemo, useRef, useState } from 'react';
import { collect, maps } from '../../api/clients';
import { idOf, withSite } from '../../api/names';
import { addressOf, Link, setQuery, usePlace } from '../../app/router';
import { onCampus, select, useSelection } from '../../app/selection';
import type { MapArea } from '../../gen/enfilade/v1/map_area_pb';
import type { MapRevision } from '../../gen/enfilade/v1/map_pb';
import { useAreas } from '../../live/areas';
import type { MapDiffRegion } from '../../gen/enfilade/v1/map_service_pb';
import { useLive } from '../../live/context';
import type { Compare, Pin, RasterChoice, View } from '../../scene/model';
import { SceneView } from '../../scene/SceneView';
import { levelName } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';
import { usePointMenu } from '../campus/PointMenu';
import { Readout, type ReadoutHandle } from '../campus/Readout';
import { Areas } from './Areas';
import { areaShown } from './areas';
import { Aliases } from './Aliases';
import { CompareBar } from './CompareBar';
import { Differences, useDifference } from './Differences';
import { Downloads } from './Downloads';
import { MapLinkPoints } from './MapLinkPoints';
import { MapUse } from './MapUse';
import { RevisionList } from './RevisionList';
import { middleOf } from './versions';

const BLINK_MS = 700;
const AREAS_POLL_MS = 30_000;

const none: MapArea[] = [];

const compares: Compare[] = ['blink', 'swipe', 'difference'];

function useRevisions(map: string, newest: string | undefined) {
  return useQuery({
    queryKey: ['revisions', map, newest],
    placeholderData: (previous: MapRevision[] | undefined) => previous,
    queryFn: () => collect(async (pageToken) => {
      const page = await maps.listMapRevisions({ parent: map, pageSize: 1000, pageToken });
      return [page.revisions, page.nextPageToken];
    }),
  });
}

// Which of the two is shown; stands still without animation.
function useBlink(on: boolean): boolean {
  const [first, setFirst] = useState(true);
  useEffect(() => {
    if (!on || window.matchMedia('(prefers-reduced-motion: reduce)').matches) return;
    const timer = setInterval(() => setFirst((before) => !before), BLINK_MS);
    return () => clearInterval(timer);
  }, [on]);
  return on && !first;
}

function rastersOf(map: string, shown: string, other: string | undefined, compare: Compare, blinked: boolean): RasterChoice[] {
  if (other === undefined) return [{ map, revision: shown, role: 'only' }];
  if (compare === 'blink') return [{ map, revision: blinked ? other : shown, role: 'only' }];
  return [{ map, revision: other, role: 'before' }, { map, revision: shown, role: 'after' }];
}

// Where the chosen region is.
function pinsOf(region: MapDiffRegion | undefined): Pin[] | undefined {
  const at = region && middleOf(region);
  return at && [{ name: 'difference', at, active: true }];
}

function MapView({ map, revisions }: { map: string; revisions: MapRevision[] }) {
  const { query } = usePlace();
  const selected = useSelection();
  const readout = useRef<ReadoutHandle>(null);
  const [swipe, setSwipe] = useState(0.5);
  const points = usePointMenu(map);
  const { data: areas = none } = useAreas(map, AREAS_POLL_MS);
  const find = (id: string | null) => revisions.find(({ name }) => idOf(name) === id);
  const shown = find(query.get('rev')) ?? revisions[0]!;
  const found = find(query.get('with'));
  const other = found === shown ? undefined : found;
  const compare = compares.find((kind) => kind === query.get('cmp')) ?? 'difference';
  const blinked = useBlink(other !== undefined && compare === 'blink');
  const pair = `${other?.name} ${shown.name}`;
  const [chosen, setChosen] = useState<{ pair: string; region: number }>();
  const region = chosen?.pair === pair ? chosen.region : undefined;
  const { data: difference } = useDifference(other, shown);
  const changed = region === undefined ? undefined : difference?.regions[region];

  const view = useMemo<View>(() => ({
    map, selected, swipe, compare: other && compare, rasters: rastersOf(map, shown.name, other?.name, compare, blinked), pins: pinsOf(changed),
    areas: areas.map(areaShown),
  }), [map, selected, swipe, compare, shown, other, blinked, changed, areas]);
  return (
    <div className="campus">
      <SceneView view={view} events={{ hover: (...at) => readout.current?.hover(...at), click: (what) => select(what), menu: points.open }}>
        <Readout ref={readout} said={points.said} />
        {points.menu}
        {other && <CompareBar shown={shown} other={other} compare={compare} blinked={blinked} swipe={swipe} setSwipe={setSwipe} difference={difference} />}
      </SceneView>
      <aside className="panel" aria-label="Details">
        <MapHead map={map} />
        <RevisionList revisions={revisions} shown={shown} other={other} show={(id) => setQuery({ rev: id })} compareWith={(id) => setQuery({ with: id })} />
        {other && <Differences base={other} revision={shown} chosen={region} choose={(i) => setChosen({ pair, region: i })} />}
        <Aliases map={map} shown={shown} isNewest={shown === revisions[0]} />
        <Downloads revision={shown} />
        <Areas map={map} areas={areas} />
        <MapLinkPoints map={map} />
        <MapUse map={map} />
      </aside>
    </div>
  );
}

function MapHead({ map }: { map: string }) {
  const live = useLive();
  const state = live.maps.get(map);
  return (
    <div className="map-head">
      <h1>{state?.displayName}</h1>
      <p className="sub">
        {levelName(state?.level ?? 0)} ·{' '}
        {state?.poseWorldMap ? <Link href={onCampus(live.id, map, state.level)}>Show on the campus</Link> : 'Not joined to the root, so not on the campus'} ·{' '}
        <Link href={addressOf(live.id, 'maps', [idOf(map), 'edit'])}>Edit</Link>
      </p>
    </div>
  );
}

// One map in its own frame, with all its revisions.
export function MapPage({ id }: { id: string }) {
  const live = useLive();
  const map = withSite(live.id, `maps/${id}`);
  const state = live.maps.get(map);
  const { data, error, refetch } = useRevisions(map, live.rasters.get(map)?.revision);
  if (!live.complete) return <Loading />;
  if (!state) {
    return (
      <Empty title="This map does not exist">
        It may have been deleted, or merged into another one. <Link href={addressOf(live.id, 'maps')}>All maps of this site</Link>
      </Empty>
    );
  }
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (data.length === 0) {
    return (
      <Empty title={`“${state.displayName}” has no revision yet`} command={`enfilade --site ${live.id} map import "${state.displayName}" FILE.yaml`}>
        Nothing has been mapped or imported. A robot that drives in it makes the first revision; a file of another program can be imported.
      </Empty>
    );
  }
  return <MapView key={map} map={map} revisions={data} />;
}

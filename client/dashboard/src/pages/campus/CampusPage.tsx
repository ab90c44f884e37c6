// SPDX-License-Identifier: Apache-2.0
import './campus.css';
import { lazy, useCallback, useEffect, useMemo, useRef, useState } from 'react';
import { collectionOf, idOf } from '../../api/names';
import { addressOf, currentPlace, navigate, setQuery, usePlace } from '../../app/router';
import { select, useLevel, useSelection } from '../../app/selection';
import { useLive } from '../../live/context';
import { formatView, parseView, type Point } from '../../scene/camera';
import type { View } from '../../scene/model';
import { SceneView, ToolButton } from '../../scene/SceneView';
import type { SceneEvents } from '../../scene/Scene';
import { sharedScene } from '../../scene/shared';
import { metres } from '../../ui/format';
import { Empty, Loading } from '../../ui/States';
import { chainOf } from './explanation';
import { useGlobalPose } from './HowKnown';
import { Inspector } from './Inspector';
import { ObjectList } from './ObjectList';
import { usePlanWalls } from './planWalls';
import { usePointMenu } from './PointMenu';
import { Readout, type ReadoutHandle } from './Readout';
import { UnplacedTray } from './UnplacedTray';

const GraphEditor = lazy(() => import('./editing/GraphEditor'));

// Two points and what lies between; a third click begins again.
function useMeasure(on: boolean) {
  const [points, setPoints] = useState<Point[]>([]);
  const scene = sharedScene();
  useEffect(() => {
    if (!on) setPoints([]);
  }, [on]);
  useEffect(() => {
    if (!scene) return;
    scene.measured = points;
    scene.touch();
  }, [scene, points]);
  const [a, b] = points;
  const text = !on ? '' : !a ? 'Click the first point' : !b ? 'Click the second point' : `${metres(Math.hypot(b.x - a.x, b.y - a.y))} apart`;
  const add = useCallback((point: Point) => setPoints((before) => (before.length === 2 ? [point] : [...before, point])), []);
  return { text, add };
}

// The camera of the address, once; later the address follows the camera.
function useAddressedCamera() {
  const scene = sharedScene();
  useEffect(() => {
    const camera = parseView(currentPlace().query.get('v'));
    if (camera) scene?.setCamera(camera);
  }, [scene]);
}

function Campus() {
  const live = useLive();
  const level = useLevel();
  const selected = useSelection();
  const scene = sharedScene();
  const readout = useRef<ReadoutHandle>(null);
  const [follow, setFollow] = useState(false);
  const [measuring, setMeasuring] = useState(false);
  const [trails, setTrails] = useState(true);
  const [plansOn, setPlansOn] = useState(true);
  const plans = usePlanWalls(live.id, level, plansOn);
  const points = usePointMenu();
  const measure = useMeasure(measuring);
  const { data: pose } = useGlobalPose(live, selected);
  useAddressedCamera();
  useEffect(() => setFollow(false), [selected]);

  const robot = selected === undefined ? undefined : live.robots.get(selected);
  const view = useMemo<View>(() => ({
    level, selected, follow, measuring, trails, plans: plans.walls, chain: pose && chainOf(live, pose),
    searchRadius: robot?.poseWorld && pose && pose.searchRadiusM > 0 ? { at: robot.poseWorld, radius: pose.searchRadiusM } : undefined,
  }), [live, level, selected, follow, measuring, trails, plans.walls, pose, robot?.poseWorld]);

  const openMap = (name: string) => collectionOf(name) === 'maps' && navigate(addressOf(live.id, 'maps', [idOf(name)]));
  const onKey = (key: string) => {
    if (key === 'f' && robot) setFollow(!follow);
    else if (key === 'm') setMeasuring(!measuring);
    else if (key === 't') setTrails(!trails);
    else if (key === 'p' && plans.exist) setPlansOn(!plansOn);
    else if (key === 'e') setQuery({ edit: 'graph' });
    else if (key === 'Escape') (measuring ? setMeasuring(false) : select(undefined));
    else if (key === 'Enter' && selected !== undefined) openMap(selected);
    else return false;
    return true;
  };
  const events: SceneEvents = {
    hover: (what, world, screen) => readout.current?.hover(what, world, screen),
    click: (what, world) => (measuring ? measure.add(world) : select(what)),
    open: openMap,
    menu: points.open,
    camera: (camera) => currentPlace().page === 'campus' && setQuery({ v: formatView(camera) }),
    taken: () => setFollow(false),
    key: onKey,
  };
  return (
    <div className="campus">
      <SceneView view={view} events={events} tools={
        <>
          <ToolButton icon="ruler" title="Measure a distance" keys="m" pressed={measuring} onClick={() => setMeasuring(!measuring)} />
          <ToolButton icon="trail" title="Show where robots come from" keys="t" pressed={trails} onClick={() => setTrails(!trails)} />
          {plans.exist && <ToolButton icon="plan" title="Show floor plans" keys="p" pressed={plansOn} onClick={() => setPlansOn(!plansOn)} />}
          <ToolButton icon="edit" title="Edit the graph" keys="e" onClick={() => setQuery({ edit: 'graph' })} />
          {selected !== undefined && <ToolButton icon="follow" title="Go to the selection" onClick={() => scene?.fit(selected)} />}
        </>
      }>
        <Readout ref={readout} said={points.said || measure.text} />
        {points.menu}
      </SceneView>
      <aside className="panel" aria-label="Details">
        {selected !== undefined && <Inspector name={selected} follow={follow} setFollow={setFollow} />}
        <UnplacedTray level={level} />
        <ObjectList level={level} />
      </aside>
    </div>
  );
}

export default function CampusPage() {
  const live = useLive();
  const level = useLevel();
  const isEditing = usePlace().query.get('edit') === 'graph';
  if (!live.complete) return <Loading />;
  if (live.maps.size === 0) {
    return (
      <Empty title="This site has no maps yet" command={`enfilade --site ${live.id} robot --robot r1 --campus figure1 --map Hall`}>
        Maps appear here as robots make them. Start one, or let the simulator drive; files of other programs are imported by “enfilade map import”.
      </Empty>
    );
  }
  if (level !== undefined && !live.levels().includes(level)) {
    return <Empty title={`There is nothing on level ${level}`}>Choose another level above, or all levels.</Empty>;
  }
  return isEditing ? <GraphEditor /> : <Campus />;
}

// SPDX-License-Identifier: Apache-2.0
import './georeference.css';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useMemo, useRef, useState } from 'react';
import { graphs } from '../../api/clients';
import { problemOf } from '../../api/errors';
import { siteName } from '../../api/names';
import { useLevel } from '../../app/selection';
import type { Georeference } from '../../gen/enfilade/v1/graph_pb';
import { converterOf, inWorld, latLonText, useGeoreference } from '../../geo/georeference';
import { OnTheGlobe } from '../../geo/OnTheGlobe';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import type { Point } from '../../scene/camera';
import type { Pin, View } from '../../scene/model';
import { SceneView } from '../../scene/SceneView';
import { sharedScene } from '../../scene/shared';
import { CopyButton } from '../../ui/CopyButton';
import { degrees, metres } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import { Empty, Failed, Loading } from '../../ui/States';
import { Readout, type ReadoutHandle } from '../campus/Readout';
import { residualOf, useDraft, type Control } from './draft';
import { Globe } from './Globe';
import { PointForm, type Chosen } from './PointForm';

function North({ yaw }: { yaw: number }) {
  return (
    <div className="north" role="img" aria-label={`North is ${degrees(Math.PI / 2 - yaw)} from the world’s x axis`}>
      <svg viewBox="-16 -16 32 32" style={{ transform: `rotate(${yaw}rad)` }}>
        <path d="M0-13 6 9 0 5-6 9z" />
      </svg>
      <span>N</span>
    </div>
  );
}

function Fit({ georeference }: { georeference: Georeference }) {
  return (
    <dl className="facts">
      <dt>Residuals (RMS)</dt>
      <dd>{metres(georeference.rmsM)}</dd>
      <dt>World’s x axis</dt>
      <dd>{degrees(georeference.yawEastWorld)} from east</dd>
      <dt>Best scale</dt>
      <dd>{georeference.bestScale.toFixed(4)} (1 is used)</dd>
    </dl>
  );
}

function Row({ control, index, residual, remove }: { control: Control; index: number; residual: number | undefined; remove: () => void }) {
  const live = useLive();
  return (
    <li className="control-point">
      <span className="control-number">{index + 1}</span>
      <span className="control-text">
        <strong>{titleOf(live, control.map)}</strong> {control.x.toFixed(2)}, {control.y.toFixed(2)} m
        <span className="sub">{latLonText(control)}</span>
        <span className="sub">{residual === undefined ? 'not saved yet' : `residual ${metres(residual)}`}</span>
      </span>
      <button className="button icon plain small" aria-label={`Remove control point ${index + 1}`} title="Remove" onClick={remove}>
        <Icon name="close" />
      </button>
    </li>
  );
}

// Where the point is that was clicked last.
function ChosenPlace({ world, convert }: { world: Point; convert: ReturnType<typeof converterOf> }) {
  const place = convert?.(world);
  return (
    <dl className="facts" aria-label="Chosen place">
      <dt>In the world</dt>
      <dd className="with-action">
        {world.x.toFixed(2)}, {world.y.toFixed(2)} m
        <CopyButton text={`${world.x} ${world.y}`} what="x y (m)" />
      </dd>
      {place && <OnTheGlobe place={place} />}
    </dl>
  );
}

function Georeferencing({ georeference }: { georeference: Georeference | null }) {
  const live = useLive();
  const level = useLevel();
  const queries = useQueryClient();
  const readout = useRef<ReadoutHandle>(null);
  const { points, isChanged, canUndo, change } = useDraft(georeference);
  const [world, setWorld] = useState<Point>();
  const [chosen, setChosen] = useState<Chosen>();
  const [hint, setHint] = useState('');
  const save = useMutation({
    mutationFn: () => graphs.setGeoreference({ site: siteName(live.id), georeference: { controlPoints: points } }),
    onSuccess: async () => {
      await queries.invalidateQueries({ queryKey: ['georeference', live.id] });
      change('forget');
    },
  });
  const convert = converterOf(live, georeference);

  const pins: Pin[] = points.flatMap((point, i) => {
    const at = inWorld(live, point);
    return at ? [{ name: `control ${i + 1}`, at, active: false }] : [];
  });
  if (world) pins.push({ name: 'chosen', at: world, active: true });
  const view = useMemo<View>(() => ({ level, pins, measuring: true }), [level, JSON.stringify(pins)]);

  const onClick = (_: string | undefined, at: Point) => {
    const scene = sharedScene();
    const map = scene?.mapAt(at);
    const inside = map === undefined ? undefined : scene?.inMap(map, at);
    setWorld(at);
    setHint(inside ? '' : 'There is no map at this place.');
    if (map !== undefined && inside) setChosen({ map, x: inside.x, y: inside.y });
  };
  const centre = convert && pins.length > 0 ? convert(pins[0]!.at) : georeference?.controlPoints[0];
  return (
    <div className="campus">
      <SceneView view={view} events={{ hover: (...over) => readout.current?.hover(...over), click: onClick }}>
        {georeference && <North yaw={georeference.yawEastWorld} />}
        <Readout ref={readout} said={hint} />
      </SceneView>
      <aside className="panel" aria-label="Details">
        <h1>Georeference</h1>
        {georeference ? (
          <>
            {centre && <Globe place={centre} />}
            <Fit georeference={georeference} />
          </>
        ) : (
          <p className="sub">This site has no place on the globe yet. Two control points give it one; more show how exact it is.</p>
        )}
        {world && <ChosenPlace world={world} convert={convert} />}
        <section className="inspector-part">
          <h2>
            Control points <span className="sub">{points.length}</span>
          </h2>
          <ol aria-label="Control points">
            {points.map((control, i) => (
              <Row key={i} control={control} index={i} residual={residualOf(control, georeference)} remove={() => change({ set: points.filter((_, other) => other !== i) })} />
            ))}
          </ol>
          <div className="actions">
            <button className="button primary" disabled={!isChanged || points.length === 1 || save.isPending} onClick={() => save.mutate()}>
              {points.length === 0 && georeference ? 'Remove the georeference' : 'Save'}
            </button>
            <button className="button" disabled={!canUndo} onClick={() => change('undo')}>
              Undo
            </button>
          </div>
          {points.length === 1 && <p className="sub">One point does not tell the direction: add another one.</p>}
          {save.error && (
            <p className="refusal" role="alert">
              {problemOf(save.error).title}: {problemOf(save.error).text}
            </p>
          )}
        </section>
        <section className="inspector-part">
          <h2>New control point</h2>
          <PointForm chosen={chosen} add={(control) => change({ set: [...points, control] })} />
        </section>
      </aside>
    </div>
  );
}

// Where the site lies on the globe, by places that are known in both.
export default function GeoreferencePage() {
  const live = useLive();
  const { data, error, refetch } = useGeoreference(live);
  if (error && data === undefined) return <Failed error={error} retry={() => void refetch()} />;
  if (data === undefined || !live.complete) return <Loading />;
  if (![...live.maps.values()].some(({ poseWorldMap }) => poseWorldMap)) {
    return (
      <Empty title="There is nothing to place on the globe yet" command={`enfilade --site ${live.id} robot --robot r1 --campus figure1 --map Hall`}>
        A georeference ties places of maps to latitude and longitude. Map something first.
      </Empty>
    );
  }
  return <Georeferencing georeference={data} />;
}

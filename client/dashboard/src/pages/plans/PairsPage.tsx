// SPDX-License-Identifier: Apache-2.0
import './plans.css';
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { useMemo, useReducer, useRef, useState } from 'react';
import { priorMaps } from '../../api/clients';
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import type { PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import { inWorld } from '../../geo/georeference';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { plansKey } from '../../live/plans';
import type { Point } from '../../scene/camera';
import type { Pin, View } from '../../scene/model';
import { SceneView } from '../../scene/SceneView';
import { sharedScene } from '../../scene/shared';
import { filesAt } from '../../ui/FileLinks';
import { metres } from '../../ui/format';
import { Icon } from '../../ui/Icon';
import { refusalOf } from '../../ui/Sending';
import { Failed, Loading } from '../../ui/States';
import { Readout, type ReadoutHandle } from '../campus/Readout';
import { changed, residualsOf, shownBefore, toMessages, type Draft, type Pair } from './pairs';
import { answerOf } from './plans';
import { Sheet } from './Sheet';

function Row({ pair: { sheet, place }, index, residual, remove }: { pair: Pair; index: number; residual: number | undefined; remove: () => void }) {
  const live = useLive();
  return (
    <li className="control-point">
      <span className="control-number">{index + 1}</span>
      <span className="control-text">
        <strong>{titleOf(live, place.map)}</strong> {place.x.toFixed(2)}, {place.y.toFixed(2)} m
        <span className="sub">
          sheet {sheet.x.toFixed(1)}, {sheet.y.toFixed(1)}
        </span>
        {residual !== undefined && <span className="sub">off by {metres(residual)}</span>}
      </span>
      <button className="button icon plain small" aria-label={`Remove pair ${index + 1}`} title="Remove" onClick={remove}>
        <Icon name="close" />
      </button>
    </li>
  );
}

// Left the sheet, right the maps of its level.
function Panes({ plan, sheet }: { plan: PriorMap; sheet: string }) {
  const live = useLive();
  const queries = useQueryClient();
  const readout = useRef<ReadoutHandle>(null);
  const [draft, change] = useReducer(changed, plan.alignment, (alignment): Draft => ({ pairs: shownBefore(alignment) }));
  const [hint, setHint] = useState('');
  const align = useMutation({
    mutationFn: async (pairs: Pair[]) => {
      const { priorMap, pairResidualsM } = await priorMaps.alignPriorMap({ name: plan.name, pairs: toMessages(pairs), etag: plan.etag });
      return { pairs, residuals: pairResidualsM, answer: answerOf(priorMap!, pairResidualsM) };
    },
    onSettled: () => queries.invalidateQueries({ queryKey: plansKey(live.id) }),
  });

  const pins: Pin[] = draft.pairs.flatMap(({ place }, i) => {
    const at = inWorld(live, place);
    return at ? [{ name: `pair ${i + 1}`, at, active: false }] : [];
  });
  const chosen = draft.place && inWorld(live, draft.place);
  if (chosen) pins.push({ name: 'chosen', at: chosen, active: true });
  const view = useMemo<View>(() => ({ level: plan.level, pins, measuring: true }), [plan.level, JSON.stringify(pins)]);

  const onClick = (_: string | undefined, at: Point) => {
    const scene = sharedScene();
    const map = scene?.mapAt(at);
    const inside = map === undefined ? undefined : scene?.inMap(map, at);
    setHint(inside ? '' : 'There is no map at this place.');
    if (map !== undefined && inside) change({ place: { map, x: inside.x, y: inside.y } });
  };
  // Of the plan as it was aligned with these pairs; else of the pairs among each other.
  const isAligned = align.data?.pairs === draft.pairs && align.data.residuals.length > 0;
  const placed = draft.pairs.map(({ place }) => inWorld(live, place));
  const residuals = isAligned ? align.data!.residuals : placed.every((p) => p !== undefined) ? residualsOf(draft.pairs.map((pair) => pair.sheet), placed) : [];
  return (
    <div className="plan-pairs">
      <Sheet src={sheet} points={draft.pairs.map((pair) => pair.sheet)} chosen={draft.sheet} choose={(point) => change({ sheet: point })} />
      <SceneView view={view} events={{ hover: (...over) => readout.current?.hover(...over), click: onClick }}>
        <Readout ref={readout} said={hint} />
      </SceneView>
      <aside className="panel" aria-label="Details">
        <h1>Points of {plan.displayName}</h1>
        <p className="sub">Click the same point on the sheet and in a map. Two pairs tell the place; four that are far apart also tell whether the plan is stretched.</p>
        {residuals.length > 0 && <p className="sub">{isAligned ? 'Off the plan as it is aligned:' : 'Off the place that fits all pairs best:'}</p>}
        <ol aria-label="Pairs">
          {draft.pairs.map((pair, i) => (
            <Row key={i} pair={pair} index={i} residual={residuals[i]} remove={() => change({ remove: i })} />
          ))}
        </ol>
        <div className="actions">
          <button className="button primary" disabled={draft.pairs.length < 2 || align.isPending} onClick={() => align.mutate(draft.pairs)}>
            Align by these points
          </button>
          <Link className="button" href={addressOf(live.id, 'plans', [idOf(plan.name)])}>
            Back to the plan
          </Link>
        </div>
        {align.isPending && <p role="status">Aligning …</p>}
        {align.error && <p className="refusal" role="alert">{refusalOf(align.error)}</p>}
        {align.data && <p className={align.data.answer.isAccepted ? undefined : 'refusal'} role="status">{align.data.answer.text}</p>}
      </aside>
    </div>
  );
}

// Two panes in which a person shows the same points.
export function PairsPage({ plan }: { plan: PriorMap }) {
  const { data, error, refetch } = useQuery({ queryKey: ['sheet', plan.name], staleTime: Infinity, queryFn: () => filesAt(`/v1/${plan.name}/files?product=sheet`) });
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  const sheet = data?.[0]?.path;
  return sheet === undefined ? <Loading /> : <Panes plan={plan} sheet={sheet} />;
}

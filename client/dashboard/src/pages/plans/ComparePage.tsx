// SPDX-License-Identifier: Apache-2.0
import './plans.css';
import { useQuery, useQueryClient } from '@tanstack/react-query';
import { useMemo, useState } from 'react';
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import type { PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import { useLive } from '../../live/context';
import type { View } from '../../scene/model';
import type { Plan } from '../../scene/plans';
import { SceneView } from '../../scene/SceneView';
import { metres } from '../../ui/format';
import { Failed, Loading } from '../../ui/States';
import { readPlanText, textKey } from './editing/planText';
import { graphOf } from './editing/graph';
import { wallsOf } from '../campus/planWalls';
import { movedBy, placedPlan } from './placed';

// The walls as the plan as a whole was placed, and as they lie on those that robots have seen, over the maps.
function Compared({ placed, corrected }: { placed: Plan; corrected: Plan }) {
  const live = useLive();
  const [share, setShare] = useState(1);
  const view = useMemo<View>(() => ({ level: placed.level, plans: [{ ...placed, alpha: 1 - share }, { ...corrected, alpha: share }] }), [placed, corrected, share]);
  const moved = movedBy(placed, corrected);
  return (
    <div className="plan-compare">
      <SceneView view={view} />
      <aside className="panel" aria-label="Details">
        <h1>Before and after</h1>
        <p className="sub">Before: the plan as it was placed as a whole. After: each wall moved onto what robots have seen of it; seen walls are green-grey, unseen ones blue, contradicted ones red and dashed; what only robots have seen is amber.</p>
        <label className="plan-fade">
          <span>Before</span>
          <input type="range" min={0} max={1} step={0.05} value={share} aria-label="From before to after"
            aria-valuetext={`${Math.round(100 * share)} % after`} onChange={(event) => setShare(Number(event.target.value))} />
          <span>After</span>
        </label>
        <div className="actions">
          <button className="button" onClick={() => setShare(share < 0.5 ? 1 : 0)}>
            {share < 0.5 ? 'Show after' : 'Show before'}
          </button>
          <Link className="button" href={addressOf(live.id, 'plans', [idOf(placed.name)])}>
            Back to the plan
          </Link>
        </div>
        {moved && <p>Walls were moved by {metres(moved.median)} in the median, by {metres(moved.most)} at most.</p>}
      </aside>
    </div>
  );
}

export function ComparePage({ plan }: { plan: PriorMap }) {
  const queries = useQueryClient();
  const { data, error, refetch } = useQuery({
    queryKey: ['planCompared', plan.name, plan.etag],
    staleTime: Infinity,
    // One after the other: the gateway exports two files at once for an address.
    queryFn: async () => {
      const text = await queries.fetchQuery({ queryKey: textKey(plan), staleTime: Infinity, queryFn: () => readPlanText(plan) });
      return { placed: placedPlan(plan, graphOf(JSON.parse(text))), corrected: await wallsOf(plan) };
    },
  });
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  return data ? <Compared placed={data.placed} corrected={data.corrected} /> : <Loading />;
}

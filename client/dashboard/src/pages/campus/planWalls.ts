// SPDX-License-Identifier: Apache-2.0
import { useQuery, useQueryClient } from '@tanstack/react-query';
import { errorOfResponse } from '../../api/errors';
import type { PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import { isPlaced, usePlans } from '../../live/plans';
import { boundsOfLines, linesOfPlan, type Plan } from '../../scene/plans';

const POLL_MS = 60_000;
const AGAIN_MS = 10_000;

export async function wallsOf({ name, level }: PriorMap): Promise<Plan> {
  const response = await fetch(`/v1/${name}/files/walls.geojson`);
  if (!response.ok) throw await errorOfResponse(response);
  const lines = linesOfPlan(await response.json());
  return { name, level, lines, bounds: boundsOfLines(lines) };
}

// Those that the campus shows; `level` undefined: of all levels.
export const shownPlans = (plans: PriorMap[], level: number | undefined) =>
  plans.filter((plan) => isPlaced(plan) && (level === undefined || plan.level === level));

// The walls of the site's plans in the world. `exist`: there is something to switch on.
export function usePlanWalls(site: string, level: number | undefined, on: boolean): { walls: Plan[]; exist: boolean } {
  const queries = useQueryClient();
  const { data: all = [] } = usePlans(site, POLL_MS);
  const shown = shownPlans(all, level);
  const { data: walls } = useQuery({
    queryKey: ['planWalls', site, ...shown.map(({ name, etag }) => `${name} ${etag}`)],
    enabled: on && shown.length > 0,
    staleTime: Infinity,
    refetchInterval: ({ state: { data } }) => data !== undefined && data.length < shown.length && AGAIN_MS,
    // One by one: the gateway exports two files at once for an address. A plan that fails leaves the others, and is tried again.
    queryFn: async () => {
      const found: Plan[] = [];
      for (const plan of shown) {
        const made = await queries.fetchQuery({ queryKey: ['planWall', plan.name, plan.etag], staleTime: Infinity, queryFn: () => wallsOf(plan) }).catch(() => undefined);
        if (made) found.push(made);
      }
      return found;
    },
  });
  return { walls: on && walls ? walls : none, exist: shown.length > 0 };
}

const none: Plan[] = [];

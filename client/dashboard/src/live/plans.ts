// SPDX-License-Identifier: Apache-2.0
// The floor plans of a site. The stream does not tell of them: they are asked for again.
import { useQuery } from '@tanstack/react-query';
import { collect, priorMaps } from '../api/clients';
import { siteName } from '../api/names';
import { PriorMap_State, type PriorMap } from '../gen/enfilade/v1/prior_map_pb';

export const plansKey = (site: string) => ['priorMaps', site];

export function usePlans(site: string, periodMs: number) {
  return useQuery({
    queryKey: plansKey(site),
    refetchInterval: periodMs,
    queryFn: () => collect(async (pageToken) => {
      const page = await priorMaps.listPriorMaps({ parent: siteName(site), pageSize: 1000, pageToken });
      return [page.priorMaps, page.nextPageToken];
    }),
  });
}

// Those that have a place in the world which is thought right.
export const isPlaced = ({ state }: PriorMap) => state === PriorMap_State.ACTIVE || state === PriorMap_State.PROPOSED;

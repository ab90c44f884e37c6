// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { collect, graphs } from '../../api/clients';
import { siteName } from '../../api/names';
import { GraphVersion_Cause as Cause, type GraphVersion } from '../../gen/enfilade/v1/graph_pb';
import { useLive } from '../../live/context';
import { count } from '../../ui/format';
import type { Places } from './movement';

// The newest; older ones are for programs.
const SHOWN = 1000;

// Of how many optimisations the server keeps where they placed the maps.
const KEPT = 50;

// The newest first, read anew when the graph changes.
export function useVersions() {
  const live = useLive();
  return useQuery({
    queryKey: ['versions', live.id, String(live.graphVersion)],
    placeholderData: (earlier: GraphVersion[] | undefined) => earlier,
    queryFn: async () => (await graphs.listGraphVersions({ parent: siteName(live.id), pageSize: SHOWN })).graphVersions,
  });
}

// Those of which it is known where the maps were, the oldest first.
export const placings = (versions: GraphVersion[]) => versions.filter(({ cause }) => cause === Cause.OPTIMIZED).slice(0, KEPT).reverse();

// Where the maps were after an optimisation: never changes. While it is read, what was there before stays.
export function usePlaces(site: string, version: bigint | undefined) {
  return useQuery({
    queryKey: ['placed maps', site, String(version)],
    enabled: version !== undefined,
    staleTime: Infinity,
    placeholderData: (earlier: Places | undefined) => earlier,
    queryFn: async (): Promise<Places> => {
      const placed = await collect(async (pageToken) => {
        const answer = await graphs.listPlacedMaps({ parent: siteName(site), graphVersion: version!, pageSize: 1000, pageToken });
        return [answer.placedMaps, answer.nextPageToken];
      });
      return new Map(placed.flatMap(({ map, poseWorldMap }) => (poseWorldMap?.pose ? [[map, poseWorldMap.pose] as const] : [])));
    },
  });
}

// How well the link points agree, before and after an optimisation.
export function agreement({ cause, chi2Before, chi2After, switchedOff }: GraphVersion): string {
  if (cause !== Cause.OPTIMIZED) return '–';
  const off = switchedOff.length > 0 ? `, ${count(switchedOff.length, 'link point')} switched off` : '';
  return `${chi2Before.toFixed(1)} → ${chi2After.toFixed(1)}${off}`;
}

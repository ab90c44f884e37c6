// SPDX-License-Identifier: Apache-2.0
// The areas of a map. The stream does not tell of them: they are asked for again.
import { useQuery } from '@tanstack/react-query';
import { collect, mapAreas } from '../api/clients';

export const areasKey = (map: string) => ['mapAreas', map];

export function useAreas(map: string, periodMs: number) {
  return useQuery({
    queryKey: areasKey(map),
    refetchInterval: periodMs,
    queryFn: () => collect(async (pageToken) => {
      const page = await mapAreas.listMapAreas({ parent: map, pageSize: 1000, pageToken });
      return [page.areas, page.nextPageToken];
    }),
  });
}

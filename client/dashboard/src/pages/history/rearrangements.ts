// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { collect, maps } from '../../api/clients';
import { siteName } from '../../api/names';

export const rearrangementsKey = (site: string) => ['rearrangements', site] as const;

export const useRearrangements = (site: string) =>
  useQuery({
    queryKey: rearrangementsKey(site),
    queryFn: () => collect(async (pageToken) => {
      const answer = await maps.listRearrangements({ parent: siteName(site), pageSize: 1000, pageToken });
      return [answer.rearrangements, answer.nextPageToken];
    }),
  });

// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { collect, sessions } from '../../../api/clients';
import { siteName } from '../../../api/names';

// All sessions of a site, also those that are over.
export const useSessionsOfSite = (site: string) =>
  useQuery({
    queryKey: ['allSessions', site],
    queryFn: () => collect(async (pageToken) => {
      const answer = await sessions.listSessions({ parent: siteName(site), pageSize: 1000, pageToken });
      return [answer.sessions, answer.nextPageToken];
    }),
  });

// SPDX-License-Identifier: Apache-2.0
import { useQueries } from '@tanstack/react-query';
import { useRef } from 'react';
import { linkPoints } from '../../../api/clients';
import type { LinkPoint } from '../../../gen/enfilade/v1/link_point_pb';
import type { LiveSite } from '../../../live/site';

export const linkPointKey = (name: string) => ['linkPoint', name] as const;

// Link points with their anchors, read anew with every version of the graph, and as they were until then. Null: the site has
// none of that name. Absent while it is read for the first time.
export function useLinkPoints(site: LiveSite, names: readonly string[]): ReadonlyMap<string, LinkPoint | null> {
  const found = new Map<string, LinkPoint | null>();
  // Of useQueries, each key begins without the data of the one before it.
  const earlier = useRef<ReadonlyMap<string, LinkPoint | null>>(found);
  // Browsers write each answer 404 to the console as an error: what the stream does not know is not asked for.
  const known = names.filter((name) => site.linkPoints.has(name));
  const answers = useQueries({
    queries: known.map((name) => ({
      queryKey: [...linkPointKey(name), String(site.graphVersion)],
      placeholderData: () => earlier.current.get(name),
      queryFn: async () => (await linkPoints.getLinkPoint({ name })).linkPoint ?? null,
    })),
  });
  known.forEach((name, i) => {
    const data = answers[i]?.data;
    if (data !== undefined) found.set(name, data);
  });
  for (const name of names) if (!site.linkPoints.has(name)) found.set(name, null);
  earlier.current = found;
  return found;
}

// SPDX-License-Identifier: Apache-2.0
import type { Fetch } from './transport';

// Other servers than the one that made a change have read it within a second, or they are ill.
const remembered_ms = 60_000;

// Calls of a site answer from the graph as this page last changed it, whichever server gets them (docs/api.md).
export function readOwnWrites(fetcher: Fetch, now: () => number = Date.now): Fetch {
  const changes = new Map<string, { version: string; until: number }>();
  return async (url, init) => {
    const site = /^\/v1\/(sites\/[^/:?]+)/.exec(url)?.[1];
    const change = site === undefined ? undefined : changes.get(site);
    const headers = new Headers(init.headers);
    if (change && change.until > now()) headers.set('Enfilade-Min-Graph-Version', change.version);
    const response = await fetcher(url, { ...init, headers });
    const version = response.headers.get('Enfilade-Graph-Version');
    if (site !== undefined && version?.startsWith(`${site}=`)) changes.set(site, { version, until: now() + remembered_ms });
    return response;
  };
}

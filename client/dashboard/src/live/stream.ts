// SPDX-License-Identifier: Apache-2.0
import { fromJson } from '@bufbuild/protobuf';
import { sites } from '../api/clients';
import { siteName } from '../api/names';
import { WatchSiteResponseSchema } from '../gen/enfilade/v1/watch_service_pb';
import { keepStream } from './eventStream';
import type { LiveSite } from './site';

// Keeps `site` up to date while the page is seen, until the returned function is called.
export function watchSite(site: LiveSite): () => void {
  let token = '';
  return keepStream({
    address: () => {
      const query = new URLSearchParams({ view: 'ROBOT_VIEW_BASIC', rateHz: '2' });
      if (token !== '') query.set('resumeToken', token);
      return `/v1/${siteName(site.id)}:watch?${query}`;
    },
    take: (json) => {
      const message = fromJson(WatchSiteResponseSchema, json, { ignoreUnknownFields: true });
      if (message.resumeToken !== '') token = message.resumeToken;
      site.apply(message, Date.now());
      if (site.state.kind !== 'live') site.setState({ kind: 'live' });
    },
    probe: async () => {
      await sites.getSite({ name: siteName(site.id) }, { timeoutMs: 3000 });
      return false;
    },
    lost: (since, retryAt, reason) => site.setState({ kind: 'lost', since, retryAt, reason }),
    refused: (error) => site.setState({ kind: 'refused', error }),
  });
}

// SPDX-License-Identifier: Apache-2.0
import { fromJson, type JsonValue } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { sites } from '../api/clients';
import { siteName } from '../api/names';
import { WatchSiteResponseSchema } from '../gen/enfilade/v1/watch_service_pb';
import type { LiveSite } from './site';

// The server sends something each 10 s.
const SILENCE_MS = 15_000;
// Then the message tells of sockets, which helps nobody here.
const silent = [Code.Canceled, Code.DeadlineExceeded, Code.Unavailable];
const RETRIES_MS = [500, 1000, 2000, 3000, 5000];

// A browser opens six connections to a host, and a stream takes one: a tab that nobody sees gives its own back after this.
const HIDDEN_MS = 5000;

// Keeps `site` up to date while the page is seen, until the returned function is called. A stream that is cut goes on where
// it was. EventSource would connect again by itself, but gives up at the first answer that is no stream, and never says why.
export function watchSite(site: LiveSite): () => void {
  let source: EventSource | undefined;
  let timer: ReturnType<typeof setTimeout> | undefined;
  let watchdog: ReturnType<typeof setTimeout> | undefined;
  let hiding: ReturnType<typeof setTimeout> | undefined;
  let token = '';
  let failures = 0;
  let lostSince = 0;
  let asleep = document.hidden;
  let stopped = false;

  const lose = (reason: string) => {
    source?.close();
    clearTimeout(watchdog);
    if (stopped || asleep) return;
    lostSince ||= Date.now();
    const wait = RETRIES_MS[Math.min(failures++, RETRIES_MS.length - 1)]!;
    site.setState({ kind: 'lost', since: lostSince, retryAt: Date.now() + wait, reason });
    clearTimeout(timer);
    timer = setTimeout(open, wait);
  };

  const guard = () => {
    clearTimeout(watchdog);
    watchdog = setTimeout(() => lose('nothing has come for 15 s'), SILENCE_MS);
  };

  const take = (event: MessageEvent<string>) => {
    guard();
    const message = fromJson(WatchSiteResponseSchema, JSON.parse(event.data) as JsonValue, { ignoreUnknownFields: true });
    if (message.resumeToken !== '') token = message.resumeToken;
    failures = 0;
    lostSince = 0;
    site.apply(message, Date.now());
    if (site.state.kind !== 'live') site.setState({ kind: 'live' });
  };

  // Without a first message an EventSource does not tell why: an ordinary call does.
  const explain = async () => {
    try {
      await sites.getSite({ name: siteName(site.id) }, { timeoutMs: 3000 });
      lose('the stream was cut');
    } catch (error) {
      const failure = ConnectError.from(error);
      if (stopped || asleep) return;
      if (failure.code === Code.NotFound) site.setState({ kind: 'refused', error });
      else lose(silent.includes(failure.code) ? 'the server does not answer' : failure.rawMessage);
    }
  };

  function open() {
    const query = new URLSearchParams({ view: 'ROBOT_VIEW_BASIC', rateHz: '2' });
    if (token !== '') query.set('resumeToken', token);
    source = new EventSource(`/v1/${siteName(site.id)}:watch?${query}`);
    guard();
    source.onmessage = take;
    source.addEventListener('failed', (event) => {
      const status = JSON.parse((event as MessageEvent<string>).data) as { code?: number; message?: string };
      lose(silent.includes(status.code as Code) ? 'the server does not answer' : (status.message ?? 'the server ended the stream'));
    });
    source.onerror = () => {
      source?.close();
      clearTimeout(watchdog);
      void explain();
    };
  }

  const close = () => {
    source?.close();
    for (const each of [timer, watchdog, hiding]) clearTimeout(each);
  };
  const sleep = () => {
    asleep = true;
    close();
  };
  const onVisibility = () => {
    clearTimeout(hiding);
    if (document.hidden) {
      hiding = setTimeout(sleep, HIDDEN_MS);
    } else if (asleep) {
      asleep = false;
      open();
    }
  };
  // A laptop that wakes up need not wait for the next attempt.
  const wake = () => {
    if (site.state.kind !== 'lost' || asleep) return;
    clearTimeout(timer);
    open();
  };
  if (!asleep) open();
  window.addEventListener('online', wake);
  document.addEventListener('visibilitychange', onVisibility);
  return () => {
    stopped = true;
    window.removeEventListener('online', wake);
    document.removeEventListener('visibilitychange', onVisibility);
    close();
  };
}

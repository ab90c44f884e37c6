// SPDX-License-Identifier: Apache-2.0
import type { JsonValue } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';

// The server sends something each 10 s.
const SILENCE_MS = 15_000;
// Then the message tells of sockets, which helps nobody here.
const silent = [Code.Canceled, Code.DeadlineExceeded, Code.Unavailable];
const RETRIES_MS = [500, 1000, 2000, 3000, 5000];

// A browser opens six connections to a host, and a stream takes one: a tab that nobody sees gives its own back after this.
const HIDDEN_MS = 5000;

export interface StreamUser {
  // From where the stream goes on.
  address(): string;
  take(message: JsonValue): void;
  // An ordinary call, for the reason why there is no stream. True: there is nothing more to come.
  probe(): Promise<boolean>;
  lost(since: number, retryAt: number, reason: string): void;
  // What is watched does not exist.
  refused(error: unknown): void;
}

// Keeps a stream open while the page is seen, until the returned function is called. A stream that is cut goes on where it
// was. EventSource would connect again by itself, but gives up at the first answer that is no stream, and never says why.
export function keepStream(user: StreamUser): () => void {
  let source: EventSource | undefined;
  let timer: ReturnType<typeof setTimeout> | undefined;
  let watchdog: ReturnType<typeof setTimeout> | undefined;
  let hiding: ReturnType<typeof setTimeout> | undefined;
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
    user.lost(lostSince, Date.now() + wait, reason);
    clearTimeout(timer);
    timer = setTimeout(open, wait);
  };

  const guard = () => {
    clearTimeout(watchdog);
    watchdog = setTimeout(() => lose('nothing has come for 15 s'), SILENCE_MS);
  };

  const take = (event: MessageEvent<string>) => {
    guard();
    failures = 0;
    lostSince = 0;
    user.take(JSON.parse(event.data) as JsonValue);
  };

  // Without a first message an EventSource does not tell why: an ordinary call does.
  const explain = async () => {
    try {
      if (await user.probe()) stop();
      else lose('the stream was cut');
    } catch (error) {
      const failure = ConnectError.from(error);
      if (stopped || asleep) return;
      if (failure.code === Code.NotFound) user.refused(error);
      else lose(silent.includes(failure.code) ? 'the server does not answer' : failure.rawMessage);
    }
  };

  function open() {
    source = new EventSource(user.address());
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
    if (lostSince === 0 || asleep) return;
    clearTimeout(timer);
    source?.close();
    open();
  };
  function stop() {
    stopped = true;
    window.removeEventListener('online', wake);
    document.removeEventListener('visibilitychange', onVisibility);
    close();
  }
  window.addEventListener('online', wake);
  document.addEventListener('visibilitychange', onVisibility);
  if (!asleep) open();
  return stop;
}

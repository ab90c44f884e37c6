// SPDX-License-Identifier: Apache-2.0
// Which page sends an operation that several could send: the one that made it, or if that is gone, the next that is opened.
import type { OperationStore, StoredOperation } from './operations';

const CHANNEL = 'enfilade.edits';
// Pages answer at once, also those that nobody sees.
const ANSWER_MS = 300;

type Message = { ask: string } | { here: string };

// Answers other pages until it is closed.
export class Presence {
  private readonly channel = typeof BroadcastChannel === 'undefined' ? undefined : new BroadcastChannel(CHANNEL);
  private readonly heard = new Set<string>();

  constructor(readonly owner: string) {
    if (!this.channel) return;
    this.channel.onmessage = ({ data }: MessageEvent<Message>) => {
      if ('here' in data) this.heard.add(data.here);
      else if (data.ask === this.owner) this.channel?.postMessage({ here: this.owner });
    };
  }

  // Those of `owners` whose pages are open.
  async alive(owners: Iterable<string>): Promise<ReadonlySet<string>> {
    const others = [...owners].filter((owner) => owner !== this.owner);
    if (others.length === 0 || !this.channel) return new Set();
    for (const ask of others) this.channel.postMessage({ ask });
    await new Promise((resolve) => setTimeout(resolve, ANSWER_MS));
    return this.heard;
  }

  close() {
    this.channel?.close();
  }
}

// What pages that are gone have left of a draft.
export async function takeOver(store: OperationStore, draft: string, presence: Presence): Promise<StoredOperation[]> {
  const all = await store.list(draft);
  const alive = await presence.alive(new Set(all.map(({ owner }) => owner)));
  const left = all.filter(({ owner }) => owner !== presence.owner && !alive.has(owner));
  await store.give(left.map(({ key }) => key), presence.owner);
  return left.map((stored) => ({ ...stored, owner: presence.owner }));
}

// SPDX-License-Identifier: Apache-2.0

const WINDOW_MS = 10_000;

// How fast a count grows, over the last 10 s in which it was told.
export class Rate {
  private readonly samples: { at: number; count: number }[] = [];

  add(at: number, count: number) {
    this.samples.push({ at, count });
    while (this.samples.length > 2 && at - this.samples[1]!.at >= WINDOW_MS) this.samples.shift();
  }

  // Each second; 0 if it has not been told for as long.
  perSecond(now: number): number {
    const first = this.samples[0];
    const last = this.samples.at(-1);
    if (!first || !last || last.at <= first.at || now - last.at > WINDOW_MS) return 0;
    return (1000 * (last.count - first.count)) / (now - first.at);
  }
}

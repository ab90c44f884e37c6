// SPDX-License-Identifier: Apache-2.0

// Integers of [low, high], the same ones for each seed (mulberry32).
export function random(seed: number): (low: number, high: number) => number {
  let state = seed;
  return (low, high) => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    const unit = ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
    return Math.ceil(low) + Math.floor(unit * (Math.floor(high) - Math.ceil(low) + 1));
  };
}

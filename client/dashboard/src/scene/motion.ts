// SPDX-License-Identifier: Apache-2.0
import { between } from './affine';
import type { Pose } from './camera';

const TWEEN_MS = 400;

interface Move {
  from: Pose;
  to: Pose;
  begin: number;
}

// Takes what the graph moves from its old place to its new one, so that a person sees what has moved. Without animation
// (prefers-reduced-motion) everything is at its place at once.
export class Motion {
  private readonly moves = new Map<string, Move>();
  private lastBegin = -Infinity;
  animated = !window.matchMedia('(prefers-reduced-motion: reduce)').matches;

  // Where it is now, on its way to `to`. `still`: it is there at once.
  at(name: string, to: Pose, now: number, still = false): Pose {
    const move = this.moves.get(name);
    if (!move || !this.animated || still) {
      this.moves.set(name, { from: to, to, begin: -Infinity });
      return to;
    }
    if (move.to.x !== to.x || move.to.y !== to.y || move.to.yaw !== to.yaw) {
      move.from = this.now(move, now);
      move.to = { ...to };
      move.begin = this.lastBegin = now;
    }
    return this.now(move, now);
  }

  moving(now: number): boolean {
    return now < this.lastBegin + TWEEN_MS;
  }

  clear() {
    this.moves.clear();
    this.lastBegin = -Infinity;
  }

  private now({ from, to, begin }: Move, now: number): Pose {
    const t = (now - begin) / TWEEN_MS;
    return t >= 1 ? to : between(from, to, t * t * (3 - 2 * t));
  }
}

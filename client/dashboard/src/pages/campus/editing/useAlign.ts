// SPDX-License-Identifier: Apache-2.0
import { useMutation } from '@tanstack/react-query';
import { useState } from 'react';
import { graphs } from '../../../api/clients';
import type { LiveSite } from '../../../live/site';
import type { Pose } from '../../../scene/camera';
import { relative } from '../../../scene/se2';
import { sharedScene } from '../../../scene/shared';
import { middleAt } from '../../../scene/moves';

export interface Pair {
  a: string;
  b: string;
  // T_a_b.
  guess: Pose;
}

export interface Reach {
  radiusM: number;
  yawRange: number;
}

// T_a_b by the graph; undefined: it does not place both.
export function poseByGraph(site: LiveSite, a: string, b: string): Pose | undefined {
  const [poseA, poseB] = [a, b].map((map) => site.maps.get(map)?.poseWorldMap?.pose);
  return poseA && poseB && relative(poseA, poseB);
}

// Middle on middle, where the graph knows no better.
function firstGuess(site: LiveSite, a: string, b: string): Pose {
  const known = poseByGraph(site, a, b);
  if (known) return known;
  const origin = { x: 0, y: 0, yaw: 0 };
  const pictures = sharedScene()?.thumbnails;
  const [inA, inB] = [middleAt(origin, pictures?.get(a)), middleAt(origin, pictures?.get(b))];
  return { x: inA.x - inB.x, y: inA.y - inB.y, yaw: 0 };
}

// Two maps of which one is laid over the other, and what the server says of how they fit.
export function useAlign(site: LiveSite) {
  const [pair, setPair] = useState<Pair>();
  const find = useMutation({
    mutationFn: async ({ pair: { a, b, guess }, reach }: { pair: Pair; reach: Reach }) =>
      graphs.alignMaps({ mapA: a, mapB: b, poseAB: guess, radiusM: reach.radiusM, yawRangeRad: reach.yawRange }),
    onSuccess: ({ poseAB }, { pair: asked }) => {
      if (poseAB?.pose) setPair({ ...asked, guess: { x: poseAB.pose.x, y: poseAB.pose.y, yaw: poseAB.pose.yaw } });
    },
  });
  return {
    pair, find,
    begin(a: string, b: string) {
      find.reset();
      setPair({ a, b, guess: firstGuess(site, a, b) });
    },
    // The answer is that of another guess then.
    move(guess: Pose) {
      find.reset();
      setPair((before) => before && { ...before, guess });
    },
    end() {
      find.reset();
      setPair(undefined);
    },
  };
}

export type Aligning = ReturnType<typeof useAlign>;

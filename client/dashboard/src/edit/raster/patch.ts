// SPDX-License-Identifier: Apache-2.0
import type { Box } from '../lattice';
import type { SpanList, Spans } from './spans';

// Row by row from the lower left of the box: how many cells to leave out, how many to take, and so on.
export function addPatch(list: SpanList, box: Box, runs: readonly number[]) {
  let at = 0;
  runs.forEach((run, i) => {
    const end = at + run;
    while (i % 2 === 1 && at < end) {
      const column = at % box.width;
      const here = Math.min(end - at, box.width - column);
      const begin = box.firstColumn + column;
      list.add(box.firstRow + Math.floor(at / box.width), begin, begin + here);
      at += here;
    }
    at = end;
  });
}

// The runs of spans within a box that has all of them.
export function runsOf(spans: Spans, box: Box): number[] {
  const runs: number[] = [];
  let at = 0;
  for (let i = 0; i < spans.length; i += 3) {
    const begin = (spans[i]! - box.firstRow) * box.width + spans[i + 1]! - box.firstColumn;
    const length = spans[i + 2]! - spans[i + 1]!;
    if (begin === at && runs.length > 0) runs[runs.length - 1]! += length;
    else runs.push(begin - at, length);
    at = begin + length;
  }
  return runs;
}

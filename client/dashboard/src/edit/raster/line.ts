// SPDX-License-Identifier: Apache-2.0
import { cellOf, type Units } from '../lattice';
import type { SpanList } from './spans';

// The cells between two by Bresenham's recurrence, as core/grid/bresenham.h has it: ties go to the cell with the greater
// coordinate on the shorter axis, so that a line and its reverse have the same cells.
function addBetween(list: SpanList, fromX: number, fromY: number, toX: number, toY: number) {
  const dx = toX - fromX;
  const dy = toY - fromY;
  const columnIsLonger = Math.abs(dx) >= Math.abs(dy);
  const steps = columnIsLonger ? Math.abs(dx) : Math.abs(dy);
  const shorter = columnIsLonger ? dy : dx;
  const [signX, signY] = [dx < 0 ? -1 : 1, dy < 0 ? -1 : 1];
  const up = 2 * Math.abs(shorter);
  let error = -steps - (shorter < 0 ? 1 : 0);
  let [x, y] = [fromX, fromY];
  list.add(y, x, x + 1);
  for (let i = 0; i < steps; ++i) {
    if (columnIsLonger) x += signX;
    else y += signY;
    error += up;
    if (error >= 0) {
      if (columnIsLonger) y += signY;
      else x += signX;
      error -= 2 * steps;
    }
    list.add(y, x, x + 1);
  }
}

export function addLine(list: SpanList, points: readonly Units[]) {
  const cells = points.map(({ x, y }) => ({ x: cellOf(x), y: cellOf(y) }));
  if (cells.length === 1) list.add(cells[0]!.y, cells[0]!.x, cells[0]!.x + 1);
  for (let i = 1; i < cells.length; ++i) addBetween(list, cells[i - 1]!.x, cells[i - 1]!.y, cells[i]!.x, cells[i]!.y);
}

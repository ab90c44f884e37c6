// SPDX-License-Identifier: Apache-2.0
import { FREE, OCCUPIED, type Value } from '../cells';
import { UNITS } from '../lattice';
import { Signal } from '../../signal';

export type ToolName = 'brush' | 'line' | 'rectangle' | 'polygon' | 'fill' | 'area';

export interface Settings {
  tool: ToolName;
  value: Value;
  // Of the brush, in cells across.
  size: number;
  // Empty: all cells.
  onlyWhere: Value[];
  invisible: boolean;
  // Shows what the draft changes in a colour of its own.
  isTinted: boolean;
}

export const sizes = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256, 512];

// Half of the size, in units.
export const radiusOf = ({ size }: Settings) => (size * UNITS) / 2;

// What the person has chosen to draw with.
export class ToolSettings {
  readonly changed = new Signal();
  private now: Settings = { tool: 'brush', value: FREE, size: 3, onlyWhere: [], invisible: false, isTinted: true };

  readonly get = () => this.now;

  set(changes: Partial<Settings>) {
    this.now = { ...this.now, ...changes };
    // What cannot be seen is there.
    if (this.now.value !== OCCUPIED) this.now.invisible = false;
    this.changed.tell();
  }

  resize(step: 1 | -1) {
    const { size } = this.now;
    const next = step > 0 ? sizes.find((other) => other > size) : sizes.filter((other) => other < size).at(-1);
    if (next !== undefined) this.set({ size: next });
  }

  swap() {
    this.set({ value: this.now.value === OCCUPIED ? FREE : OCCUPIED });
  }
}

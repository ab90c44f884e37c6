// SPDX-License-Identifier: Apache-2.0
import { titleOf } from '../live/objects';
import type { Drawn, Frame } from './model';

const MOST = 60;

interface Placed {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

// Names over the canvas, as text that screen and zoom of the browser know. Those that would lie on another one are left out:
// the selected thing first, then robots, then maps.
export class Labels {
  readonly element = document.createElement('div');
  private readonly pool: HTMLSpanElement[] = [];

  constructor() {
    this.element.className = 'labels';
    this.element.setAttribute('aria-hidden', 'true');
  }

  draw(frame: Frame) {
    const placed: Placed[] = [];
    let used = 0;
    for (const item of this.ordered(frame)) {
      if (used >= MOST) break;
      const text = titleOf(frame.site, item.name);
      const width = text.length * 7 + 8;
      const { x, y } = item.label;
      const box = { left: x - width / 2, right: x + width / 2, top: y - 9, bottom: y + 9 };
      if (placed.some((other) => box.left < other.right && other.left < box.right && box.top < other.bottom && other.top < box.bottom)) continue;
      placed.push(box);
      this.show(used++, item, text, x, y);
    }
    for (let i = used; i < this.pool.length; ++i) this.pool[i]!.hidden = true;
  }

  private ordered({ drawn, size, view }: Frame): Drawn[] {
    const inView = ({ x, y }: Drawn) => x > 0 && y > 0 && x < size.width && y < size.height;
    const large = ({ halfX, halfY }: Drawn) => Math.max(halfX, halfY) > 32;
    const shown = drawn.filter((item) => inView(item) && !item.ghost && (item.name === view.selected || item.kind === 'robot' || (item.kind === 'map' && large(item) && view.map === undefined)));
    const rank = (item: Drawn) => (item.name === view.selected ? 0 : item.kind === 'robot' ? 1 : 2);
    return shown.sort((a, b) => rank(a) - rank(b) || b.halfX - a.halfX).slice(0, 4 * MOST);
  }

  private show(i: number, item: Drawn, text: string, x: number, y: number) {
    let label = this.pool[i];
    if (!label) {
      label = document.createElement('span');
      this.pool.push(label);
      this.element.append(label);
    }
    label.hidden = false;
    if (label.textContent !== text) label.textContent = text;
    label.className = `label-${item.kind}`;
    label.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px) translate(-50%, -50%)`;
  }
}

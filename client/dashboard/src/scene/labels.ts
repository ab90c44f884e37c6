// SPDX-License-Identifier: Apache-2.0
import { titleOf } from '../live/objects';
import type { Drawn, Frame, View } from './model';

const MOST = 60;

interface Placed {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

interface Label {
  element: HTMLSpanElement;
  // What it names; undefined: it is hidden.
  item: Drawn | undefined;
}

// Which names are shown is chosen anew that often while the map is only dragged; their places follow each frame.
export const CHOICE_MS = 150;

// Names over the canvas, as text that screen and zoom of the browser know. Those that would lie on another one are left out:
// the selected thing first, then robots, then maps.
export class Labels {
  readonly element = document.createElement('div');
  private readonly pool: Label[] = [];
  private chosenAt = -Infinity;
  private scale = 0;
  private view: View | undefined;

  constructor() {
    this.element.className = 'labels';
    this.element.setAttribute('aria-hidden', 'true');
  }

  // Returns whether the choice is kept from an earlier frame: then another frame is due.
  draw(frame: Frame): boolean {
    const { camera, view, now } = frame;
    const kept = camera.scale === this.scale && view === this.view && now < this.chosenAt + CHOICE_MS;
    if (!kept) {
      this.choose(frame);
      this.chosenAt = now;
      this.scale = camera.scale;
      this.view = view;
    }
    for (const { element, item } of this.pool) {
      if (item) element.style.transform = `translate(${Math.round(item.label.x)}px, ${Math.round(item.label.y)}px) translate(-50%, -50%)`;
    }
    return kept;
  }

  private choose(frame: Frame) {
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
      this.show(used++, item, text);
    }
    for (const label of this.pool.slice(used)) {
      label.element.hidden = true;
      label.item = undefined;
    }
  }

  private ordered({ drawn, size, view }: Frame): Drawn[] {
    const inView = ({ x, y }: Drawn) => x > 0 && y > 0 && x < size.width && y < size.height;
    const large = ({ halfX, halfY }: Drawn) => Math.max(halfX, halfY) > 32;
    const shown = drawn.filter((item) => inView(item) && !item.ghost && (item.name === view.selected || item.kind === 'robot' || (item.kind === 'map' && large(item) && view.map === undefined)));
    const rank = (item: Drawn) => (item.name === view.selected ? 0 : item.kind === 'robot' ? 1 : 2);
    return shown.sort((a, b) => rank(a) - rank(b) || b.halfX - a.halfX).slice(0, 4 * MOST);
  }

  private show(i: number, item: Drawn, text: string) {
    let label = this.pool[i];
    if (!label) {
      label = { element: document.createElement('span'), item };
      this.pool.push(label);
      this.element.append(label.element);
    }
    const { element } = label;
    label.item = item;
    element.hidden = false;
    if (element.textContent !== text) element.textContent = text;
    element.className = `label-${item.kind}`;
  }
}

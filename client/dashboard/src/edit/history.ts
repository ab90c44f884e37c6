// SPDX-License-Identifier: Apache-2.0
import type { Entry } from './draft';

// A person's own steps: what the edits of one gesture are is undone and redone together.
export class History {
  private done: string[][] = [];
  private undone: string[][] = [];

  // `isActive`: somebody else may have switched an edit off or on.
  constructor(private readonly isActive: (id: string) => boolean) {}

  get canUndo(): boolean {
    return this.done.some((step) => step.some(this.isActive));
  }
  get canRedo(): boolean {
    return this.undone.some((step) => step.some((id) => !this.isActive(id)));
  }

  add(step: string[]) {
    this.done.push(step);
    this.undone = [];
  }

  // The edits to switch off; empty: there is nothing to undo.
  undo(): string[] {
    return turn(this.done, this.undone, this.isActive);
  }

  // The edits to switch on.
  redo(): string[] {
    return turn(this.undone, this.done, (id) => !this.isActive(id));
  }

  // An edit that has come to nothing.
  forget(id: string) {
    const without = (steps: string[][]) => steps.map((step) => step.filter((other) => other !== id)).filter((step) => step.length > 0);
    this.done = without(this.done);
    this.undone = without(this.undone);
  }

  // From the edits of an author, when a page is opened: what was switched off after the author's last edit that is on can be
  // switched on again.
  remember(entries: Iterable<Entry>, author: string) {
    const known = new Set([...this.done, ...this.undone].flat());
    const own = [...entries].filter(({ edit }) => edit.author === author && !known.has(edit.editId)).sort((a, b) => a.layer.order - b.layer.order);
    let last = own.length - 1;
    while (last >= 0 && !own[last]!.layer.active) --last;
    this.done = [...own.filter(({ layer }) => layer.active).map(({ edit }) => [edit.editId]), ...this.done];
    this.undone = [...own.slice(last + 1).reverse().map(({ edit }) => [edit.editId]), ...this.undone];
  }
}

function turn(from: string[][], to: string[][], applies: (id: string) => boolean): string[] {
  for (;;) {
    const step = from.pop();
    if (!step) return [];
    const ids = step.filter(applies);
    if (ids.length === 0) continue;
    to.push(step);
    return ids;
  }
}

// SPDX-License-Identifier: Apache-2.0
import { useSyncExternalStore } from 'react';
import { Signal } from '../signal';

// What a person has entered, which this browser keeps. Storage may be forbidden: then it holds until the page is closed.
class Kept<T extends string> {
  private readonly changed = new Signal();
  private value: T;
  readonly subscribe = this.changed.subscribe;

  // `read`: what holds, of what was kept.
  constructor(private readonly key: string, read: (kept: string | null) => T) {
    this.value = read(keptAt(key));
  }

  get = () => this.value;

  set(value: T) {
    this.value = value;
    try {
      localStorage.setItem(this.key, value);
    } catch {
      // See above.
    }
    this.changed.tell();
  }

  use = () => useSyncExternalStore(this.subscribe, this.get);
}

function keptAt(key: string): string | null {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

// One of several choices: the first one holds until another is chosen.
export class Setting<T extends string> extends Kept<T> {
  constructor(key: string, readonly choices: readonly T[]) {
    super(key, (kept) => choices.find((choice) => choice === kept) ?? choices[0]!);
  }
}

// Any text; empty until there is one.
export class TextSetting extends Kept<string> {
  constructor(key: string) {
    super(key, (kept) => kept ?? '');
  }
}

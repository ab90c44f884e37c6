// SPDX-License-Identifier: Apache-2.0
import { useSyncExternalStore } from 'react';
import { Signal } from '../signal';

// A choice of the person, which this browser keeps. Storage may be forbidden: then it holds until the page is closed.
export class Setting<T extends string> {
  private readonly changed = new Signal();
  private value: T;
  readonly subscribe = this.changed.subscribe;

  // `choices`: the first one holds until another is chosen.
  constructor(private readonly key: string, readonly choices: readonly T[]) {
    this.value = this.read();
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

  private read(): T {
    try {
      return this.choices.find((choice) => choice === localStorage.getItem(this.key)) ?? this.choices[0]!;
    } catch {
      return this.choices[0]!;
    }
  }
}

// SPDX-License-Identifier: Apache-2.0
// Tells whoever has subscribed. A listener that goes while others are being told is still told this once.
export class Signal {
  private readonly listeners = new Set<() => void>();

  // Returns how to stop. Bound, so that it can be given to useSyncExternalStore.
  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => {
      this.listeners.delete(listener);
    };
  };

  tell() {
    for (const listener of [...this.listeners]) listener();
  }
}

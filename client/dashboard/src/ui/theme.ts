// SPDX-License-Identifier: Apache-2.0
import { useSyncExternalStore } from 'react';

export type Theme = 'auto' | 'light' | 'dark';
export type Shade = 'light' | 'dark';

const KEY = 'enfilade.theme';
const dark = window.matchMedia('(prefers-color-scheme: dark)');
const listeners = new Set<() => void>();

function read(): Theme {
  try {
    const stored = localStorage.getItem(KEY);
    return stored === 'light' || stored === 'dark' ? stored : 'auto';
  } catch {
    return 'auto'; // storage may be forbidden
  }
}

let theme = read();

export const shade = (): Shade => (theme === 'auto' ? (dark.matches ? 'dark' : 'light') : theme);

function show() {
  document.documentElement.dataset.theme = shade();
  for (const listener of [...listeners]) listener();
}

export function setTheme(next: Theme) {
  theme = next;
  try {
    localStorage.setItem(KEY, next);
  } catch {
    // Holds until the page is closed.
  }
  show();
}

export function onThemeChange(listener: () => void) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

export const useTheme = () => useSyncExternalStore(onThemeChange, () => theme);

dark.addEventListener('change', show);
show();

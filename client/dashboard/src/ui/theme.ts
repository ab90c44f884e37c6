// SPDX-License-Identifier: Apache-2.0
import { useSyncExternalStore } from 'react';
import { Signal } from '../signal';

export type Theme = 'auto' | 'light' | 'dark';
export type Shade = 'light' | 'dark';

const KEY = 'enfilade.theme';
const dark = window.matchMedia('(prefers-color-scheme: dark)');
const changed = new Signal();

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
  changed.tell();
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

export const onThemeChange = changed.subscribe;

export const useTheme = () => useSyncExternalStore(onThemeChange, () => theme);

dark.addEventListener('change', show);
show();

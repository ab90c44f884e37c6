// SPDX-License-Identifier: Apache-2.0
// Which of the style sheet's colours hold: its rules look at the attributes data-theme and data-colours.
import { Signal } from '../signal';
import { Setting } from './setting';

export const theme = new Setting('enfilade.theme', ['auto', 'light', 'dark']);
export type Theme = (typeof theme.choices)[number];

// Of maps and what lies on them.
export const mapColours = new Setting('enfilade.colours', ['standard', 'classic', 'contrast', 'colour-blind']);
export type MapColours = (typeof mapColours.choices)[number];

const dark = window.matchMedia('(prefers-color-scheme: dark)');
const contrast = window.matchMedia('(prefers-contrast: more)');
const changed = new Signal();

function show() {
  const chosen = theme.get();
  const colours = mapColours.get();
  const { dataset } = document.documentElement;
  dataset.theme = chosen === 'auto' ? (dark.matches ? 'dark' : 'light') : chosen;
  dataset.colours = colours === 'standard' && contrast.matches ? 'contrast' : colours;
  changed.tell();
}

export const onColoursChange = changed.subscribe;

for (const setting of [theme, mapColours]) setting.subscribe(show);
for (const preference of [dark, contrast]) preference.addEventListener('change', show);
show();

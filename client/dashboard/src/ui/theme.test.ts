// SPDX-License-Identifier: Apache-2.0
// The colours of the scene in all themes: seen on free space, and told apart by people who lack one kind of cone.
import { readFileSync } from 'node:fs';
import { expect, test } from 'vitest';
import { parseColour, type Rgb } from '../scene/palette';

const sheet = readFileSync(new URL('./styles/theme.css', import.meta.url), 'utf8');
const objects = ['robot', 'link', 'candidate', 'blocked', 'select'];
const themes = ['light', 'dark'];
const palettes = ['standard', 'classic', 'contrast', 'colour-blind'];

// The scene's colours, as the style sheet's cascade gives them.
function coloursOf(theme: string, palette: string): Map<string, Rgb> {
  const found = new Map<string, Rgb>();
  const selectors = [':root', ...(theme === 'dark' ? [":root[data-theme='dark']"] : []), `:root[data-colours='${palette}']`,
    ...(theme === 'dark' ? [`:root[data-theme='dark'][data-colours='${palette}']`] : [])];
  for (const selector of selectors) {
    const body = sheet.split(`\n${selector} {`)[1]?.split('\n}')[0] ?? '';
    for (const [, name, value] of body.matchAll(/--scene-([a-z-]+): (#[0-9a-f]{6});/g)) found.set(name!, parseColour(value!));
  }
  return found;
}

const linear = (colour: Rgb) => colour.map((value) => (value <= 10.31475 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4));

// WCAG 2.2, relative luminance.
const luminance = (colour: Rgb) => linear(colour).reduce((sum, value, i) => sum + [0.2126, 0.7152, 0.0722][i]! * value, 0);

function contrast(a: Rgb, b: Rgb): number {
  const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (light! + 0.05) / (dark! + 0.05);
}

// Machado, Oliveira, Fernandes 2009, severity 1: linear RGB as it is seen.
const sights: Record<string, number[][]> = {
  'all cones': [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
};

// CIE L*a*b* under D65.
function lab([r, g, b]: number[]): number[] {
  const f = (t: number) => (t > 216 / 24389 ? Math.cbrt(t) : ((24389 / 27) * t + 16) / 116);
  const x = f((0.4124 * r! + 0.3576 * g! + 0.1805 * b!) / 0.9505);
  const y = f(0.2126 * r! + 0.7152 * g! + 0.0722 * b!);
  const z = f((0.0193 * r! + 0.1192 * g! + 0.9505 * b!) / 1.089);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

const seen = (colour: Rgb, sight: number[][]) =>
  lab(sight.map((row) => Math.min(1, Math.max(0, row.reduce((sum, part, i) => sum + part * linear(colour)[i]!, 0)))));

// WCAG 2.2, 1.4.11: 3 : 1 for what is not text; where high contrast is asked for, what text needs at level AAA.
test('objects stand out against free space', () => {
  for (const theme of themes) {
    for (const palette of palettes) {
      const colours = coloursOf(theme, palette);
      for (const name of ['occupied', 'plan-seen', 'plan-unseen', ...objects]) {
        expect(contrast(colours.get(name)!, colours.get('free')!), `${name}, ${theme}, ${palette}`).toBeGreaterThan(palette === 'contrast' ? 7 : 3);
      }
    }
  }
});

// The just noticeable difference is about 2.3.
test('the colours for colour blindness are told apart with any cone missing', () => {
  for (const theme of themes) {
    const colours = coloursOf(theme, 'colour-blind');
    for (const [name, sight] of Object.entries(sights)) {
      for (const [i, a] of objects.entries()) {
        for (const b of objects.slice(i + 1)) {
          const [left, right] = [seen(colours.get(a)!, sight), seen(colours.get(b)!, sight)];
          const distance = Math.hypot(...left.map((value, k) => value - right[k]!));
          expect(distance, `${a} and ${b}, ${theme}, ${name}`).toBeGreaterThan(25);
        }
      }
    }
  }
});

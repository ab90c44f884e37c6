// SPDX-License-Identifier: Apache-2.0
// The colours of the scene, from the style sheet's custom properties, so that canvas and page have one theme.

export type Rgb = [number, number, number];

export interface Palette {
  dark: boolean;
  // What is drawn for each of the 256 values of a cell; alpha 0 unknown, 128 free, 255 occupied.
  cells: Uint8Array;
  background: [number, number, number, number];
  select: [number, number, number, number];
  before: [number, number, number, number];
  after: [number, number, number, number];
  colour: Record<'robot' | 'stale' | 'link' | 'candidate' | 'blocked' | 'off' | 'select' | 'halo' | 'grid' | 'planSeen' | 'planUnseen', Rgb>;
}

export function parseColour(text: string): Rgb {
  const short = /^#([0-9a-f])([0-9a-f])([0-9a-f])$/i;
  const digits = /^#([0-9a-f]{6})$/i.exec(text.trim().replace(short, '#$1$1$2$2$3$3'))?.[1];
  if (digits === undefined) throw new Error(`not a colour of the form #rrggbb: "${text}"`);
  return [0, 2, 4].map((i) => parseInt(digits.slice(i, i + 2), 16)) as Rgb;
}

// As the bytes of a little-endian word, alpha in [0, 1].
export const rgba = ([r, g, b]: Rgb, alpha = 1) => ((Math.round(alpha * 255) << 24) | (b << 16) | (g << 8) | r) >>> 0;

const unit = ([r, g, b]: Rgb): [number, number, number, number] => [r / 255, g / 255, b / 255, 1];

// Thumbnails have these two values besides 0, and so both fit one table: value 0 is unknown, 1 to 255 are probabilities.
export const THUMBNAIL_FREE = 1;
export const THUMBNAIL_OCCUPIED = 255;

// `classes`: 0 unknown, 1 free, 2 occupied for each value. The surer, the nearer to the full colour.
export function cellColours(classes: Uint8Array, free: Rgb, occupied: Rgb): Uint8Array {
  const cells = new Uint8Array(4 * 256);
  for (let value = 1; value < 256; ++value) {
    const probability = (value - 1) / 254;
    const kind = classes[value];
    if (kind === 1) {
      cells.set(free.map((c, i) => Math.round(c + (occupied[i]! - c) * 0.15 * Math.min(1, probability / 0.5))), 4 * value);
      cells[4 * value + 3] = 128;
    } else if (kind === 2) {
      cells.set(occupied.map((c, i) => Math.round(c + (free[i]! - c) * 0.25 * Math.min(1, (1 - probability) / 0.5))), 4 * value);
      cells[4 * value + 3] = 255;
    }
  }
  return cells;
}

// Until a manifest tells better: the thresholds of the API's documentation.
export const defaultClasses = Uint8Array.from({ length: 256 }, (_, value) =>
  value === 0 ? 0 : (value - 1) / 254 >= 0.65 ? 2 : (value - 1) / 254 <= 0.25 ? 1 : 0,
);

export function readPalette(classes: Uint8Array): Palette {
  const root = getComputedStyle(document.documentElement);
  const colour = (name: string) => parseColour(root.getPropertyValue(`--scene-${name}`));
  const dark = document.documentElement.dataset.theme === 'dark';
  return {
    dark,
    cells: cellColours(classes, colour('free'), colour('occupied')),
    background: unit(colour('bg')),
    select: unit(colour('select')),
    before: unit(parseColour(root.getPropertyValue('--compare-before'))),
    after: unit(parseColour(root.getPropertyValue('--compare-after'))),
    colour: {
      robot: colour('robot'), stale: colour('robot-stale'), link: colour('link'), candidate: colour('candidate'),
      blocked: colour('blocked'), off: colour('off'), select: colour('select'), halo: colour('halo'), grid: colour('grid'),
      planSeen: colour('plan-seen'), planUnseen: colour('plan-unseen'),
    },
  };
}

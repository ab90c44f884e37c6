// SPDX-License-Identifier: Apache-2.0
// The editor of maps in a browser, and what the server has of its drafts.
import { createHash } from 'node:crypto';
import { open } from './browser.mjs';
import { importMap, pgmOf } from './maps.mjs';
import { until } from './system.mjs';

export const TILE = 256;

const [WIDTH, HEIGHT] = [600, 400]; // cells: 3 x 2 tiles
const isWall = (x, y) => x === 0 || y === 0 || x === WIDTH - 1 || y === HEIGHT - 1 || (x === 300 && y > 100);

// A map of a room with a wall, in the site `editing`.
export async function newMap(system, id) {
  await importMap(system, 'editing', id, pgmOf(WIDTH, HEIGHT, isWall));
  return `sites/editing/maps/${id}`;
}

// The same numbers each time.
export function random(seed) {
  let state = seed;
  return (limit) => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return Math.floor((state / 2147483648) * limit);
  };
}

export async function newDraft(system, map, displayName = 'Draft') {
  const { draft } = await system.call(`${map}/drafts`, { displayName, author: 'Test' });
  return draft.name;
}

export const editorAddress = (system, draft) => {
  const [, site, , map, , id] = draft.split('/');
  return `${system.url}/s/${site}/maps/${map}/edit/${id}`;
};

export const statsOf = (page) => page.evaluate(() => window.__editor.stats());
export const digestsOf = (page) => page.evaluate(() => window.__editor.digests());
// Everything is drawn, stored and acknowledged.
export const stored = (page) => page.waitForFunction(() => window.__editor?.settled(), undefined, { timeout: 60_000 });

// What edits say of a cell: 0 nothing, 1 unknown, 2 free, 3 occupied.
export const editedAt = (page, column, row) => page.evaluate(([c, r]) => (window.__editor.cell(r, c) >> 2) & 3, [column, row]);

// Enters the name, if the browser does not know it yet.
export async function introduce(page, author) {
  await page.getByRole('textbox', { name: 'Your name' }).fill(author);
  await page.keyboard.press('Enter');
}

// A browser of its own for `author`, on the draft.
export async function openEditor(browser, system, draft, author, options = {}) {
  const opened = await open(browser, editorAddress(system, draft), options);
  await introduce(opened.page, author);
  await stored(opened.page);
  return opened;
}

// The middle of a cell on the screen.
export async function screenOf(page, column, row) {
  const [camera, box] = await page.evaluate(() => {
    const { x, y, width, height } = document.querySelector('.edit-canvas').getBoundingClientRect();
    return [window.__editor.camera(), { x, y, width, height }];
  });
  return {
    x: box.x + box.width / 2 + (column + 0.5 - camera.x) * camera.scale,
    y: box.y + box.height / 2 - (row + 0.5 - camera.y) * camera.scale,
  };
}

export async function lookAt(page, x, y, scale) {
  await page.evaluate((camera) => window.__editor.setCamera(camera), { x, y, scale });
}

// Presses the pointer at the first cell, goes over the others, and lets it go at the last.
export async function drag(page, ...cells) {
  const points = [];
  for (const [column, row] of cells) points.push(await screenOf(page, column, row));
  await page.mouse.move(points[0].x, points[0].y);
  await page.mouse.down();
  for (const { x, y } of points.slice(1)) await page.mouse.move(x, y);
  await page.mouse.up();
}

export async function click(page, column, row) {
  const { x, y } = await screenOf(page, column, row);
  await page.mouse.click(x, y);
}

// All edits of a draft, in their order.
export async function editsOf(system, draft) {
  const edits = [];
  for (let token = ''; ;) {
    const page = await system.call(`${draft}/edits?pageSize=1000&pageToken=${encodeURIComponent(token)}`);
    edits.push(...(page.edits ?? []));
    token = page.nextPageToken ?? '';
    if (token === '') return edits.sort((a, b) => Number(a.sequence) - Number(b.sequence));
  }
}

// The tiles as the server has them: { row, column, cells }.
export async function readTiles(system, draft, places) {
  const tiles = [];
  for (let i = 0; i < places.length; i += 16) {
    const answer = await system.call(`${draft}:readTiles`, { tiles: places.slice(i, i + 16) });
    for (const { row = 0, column = 0, cells } of answer.tiles) tiles.push({ row, column, cells: Buffer.from(cells, 'base64') });
  }
  return tiles;
}

// Of what edits say, by "row,column".
export async function serverDigests(system, draft, keys) {
  const places = keys.map((key) => ({ row: Number(key.split(',')[0]), column: Number(key.split(',')[1]) }));
  const tiles = await readTiles(system, draft, places);
  return Object.fromEntries(tiles.map(({ row, column, cells }) => [`${row},${column}`, createHash('sha256').update(cells.map((cell) => (cell >> 2) & 3)).digest('hex')]));
}

// Waits until the page has all that the server has; then the digests of both should be the same.
export async function sameAsServer(page, system, draft) {
  const headOf = async () => Number((await system.call(draft)).draft.head ?? 0);
  return until('the page has all that the server has', async () => {
    await stored(page);
    const head = await headOf();
    // At one time: another's edit may come between two questions.
    const { own, reached } = await page.evaluate(() => ({ own: window.__editor.digests(), reached: window.__editor.stats().head }));
    if (reached !== head) return undefined;
    const server = await serverDigests(system, draft, Object.keys(own));
    return (await headOf()) === head ? { own, server } : undefined;
  });
}

// Opens the dialog that publishes, and says why.
export async function publish(page, message) {
  await page.getByRole('button', { name: 'Publish …' }).click();
  const dialog = page.getByRole('dialog', { name: 'Publish the draft' });
  await dialog.getByLabel('What was edited, and why').fill(message);
  return dialog;
}

export const send = (dialog) => dialog.getByRole('button', { name: 'Publish', exact: true }).click();

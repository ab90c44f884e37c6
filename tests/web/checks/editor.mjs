// SPDX-License-Identifier: Apache-2.0
// Maps that are edited in the browser, by real pointers and keys, against what the server then has.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultsOf, open, picture } from '../browser.mjs';
import { click, digestsOf, drag, editedAt, editorAddress, editsOf, introduce, lookAt, newDraft, newMap, openEditor, random, sameAsServer, screenOf, statsOf, stored } from '../editing.mjs';
import { importMap, pgmOf } from '../maps.mjs';

const SITE = 'editing';
const [WIDTH, HEIGHT] = [600, 400]; // of the maps that `newMap` makes

const [UNKNOWN, FREE, OCCUPIED] = [1, 2, 3];

async function bytesOf(system, map) {
  const { files } = await (await fetch(`${system.url}/v1/${map}/files?format=pgm`)).json();
  const { path } = files.find(({ name }) => name.endsWith('.pgm'));
  return Buffer.from(await (await fetch(`${system.url}${path}`)).arrayBuffer());
}

const revisionsOf = async (system, map) => (await system.call(`${map}/revisions`)).revisions ?? [];

// The cells within the radius of a path, by the definition: of an edit as the server gives it.
function cellsOf({ brush: { points, radius } }) {
  const cells = new Set();
  const ends = points.map(({ x = 0, y = 0 }) => [BigInt(x), BigInt(y)]);
  const segments = ends.length === 1 ? [[ends[0], ends[0]]] : ends.slice(1).map((end, i) => [ends[i], end]);
  const r2 = BigInt(radius) ** 2n;
  for (const [[ax, ay], [bx, by]] of segments) {
    const low = (a, b) => Number(((a < b ? a : b) - BigInt(radius)) / 256n) - 1;
    const high = (a, b) => Number(((a > b ? a : b) + BigInt(radius)) / 256n) + 1;
    const [dx, dy] = [bx - ax, by - ay];
    const length2 = dx * dx + dy * dy;
    for (let row = low(ay, by); row <= high(ay, by); ++row) {
      for (let column = low(ax, bx); column <= high(ax, bx); ++column) {
        const [x, y] = [BigInt(column * 256 + 128), BigInt(row * 256 + 128)];
        const along = (x - ax) * dx + (y - ay) * dy;
        const isIn = along <= 0n ? (x - ax) ** 2n + (y - ay) ** 2n <= r2
          : along >= length2 ? (x - bx) ** 2n + (y - by) ** 2n <= r2
          : ((x - ax) * dy - (y - ay) * dx) ** 2n <= r2 * length2;
        if (isIn) cells.add(`${column},${row}`);
      }
    }
  }
  return cells;
}

export function addEditor({ system, browser, at }) {
  test('lossless: strokes that are undone leave no trace, and one stroke changes its cells and no others', async () => {
    const map = await newMap(system, 'lossless');
    const before = await bytesOf(system, map);
    const draft = await newDraft(system, map);
    const { page, close } = await openEditor(browser(), system, draft, 'Ann');
    const start = await digestsOf(page);
    const next = random(14);
    await lookAt(page, WIDTH / 2, HEIGHT / 2, 1.2);
    for (let i = 0; i < 50; ++i) {
      await page.keyboard.press(String(1 + next(4)));
      const from = [50 + next(500), 40 + next(320)];
      await drag(page, from, [from[0] + next(40), from[1] + next(30)], [from[0] + next(40), from[1] - next(30)]);
    }
    await stored(page);
    assert.equal((await editsOf(system, draft)).length, 50);
    assert.notDeepEqual(await digestsOf(page), start);
    for (let i = 0; i < 50; ++i) await page.keyboard.press('Control+z');
    const undone = await sameAsServer(page, system, draft);
    assert.deepEqual(undone.own, start);
    assert.deepEqual(undone.server, start);
    assert.equal((await revisionsOf(system, map)).length, 1);
    assert.deepEqual(await bytesOf(system, map), before);

    // One stroke, published.
    await page.keyboard.press('2');
    await drag(page, [100, 100], [140, 120], [150, 60]);
    await stored(page);
    await page.getByRole('button', { name: 'Publish …' }).click();
    const dialog = page.getByRole('dialog', { name: 'Publish the draft' });
    await dialog.getByLabel('What was edited, and why').fill('A wall');
    await dialog.getByRole('button', { name: 'Publish', exact: true }).click();
    await dialog.getByText('Published:').waitFor();
    const [edit] = (await editsOf(system, draft)).filter(({ active }) => active);
    const cells = cellsOf(edit);
    const after = await bytesOf(system, map);
    assert.equal(after.length, before.length);
    const head = before.length - WIDTH * HEIGHT;
    for (let i = 0; i < before.length; ++i) {
      const [column, row] = [(i - head) % WIDTH, HEIGHT - 1 - Math.floor((i - head) / WIDTH)];
      if (i < head || !cells.has(`${column},${row}`)) assert.equal(after[i], before[i], `byte ${i}, cell ${column}, ${row}`);
      else assert.ok(after[i] < 89, `cell ${column}, ${row} is occupied: ${after[i]}`);
    }
    assert.equal((await statsOf(page)).mismatches, 0);
    await close();
  });

  test('edit_tools: each tool by the pointer has the server’s cells', async () => {
    const map = await newMap(system, 'tools');
    const draft = await newDraft(system, map);
    const { page, close } = await openEditor(browser(), system, draft, 'Ann');
    await lookAt(page, 200, 200, 3);
    const keys = async (...all) => { for (const key of all) await page.keyboard.press(key); };

    await keys('b', '2', ']');
    await drag(page, [110, 110], [150, 115]);
    await keys('[', '[', '[', 'l', '3');
    await drag(page, [110, 130], [180, 150]);
    await keys('r', '2');
    await drag(page, [200, 110], [220, 130]);
    await keys('g', '1');
    for (const corner of [[205, 115], [230, 118], [212, 140]]) await click(page, ...corner);
    await keys('Enter', 'r', '4');
    await drag(page, [200, 110], [202, 112]);
    await keys('r', '2');
    await drag(page, [240, 200], [280, 240]);
    await keys('f', '1');
    await click(page, 260, 220);
    await page.waitForFunction(() => ((window.__editor.cell(220, 260) >> 2) & 3) === 2);
    await stored(page);
    assert.equal(await editedAt(page, 110, 130), UNKNOWN, 'the line begins where the pointer went down');
    assert.equal(await editedAt(page, 180, 150), UNKNOWN, 'and ends where it came up');
    assert.equal(await editedAt(page, 130, 112), OCCUPIED, 'the brush');
    assert.equal(await editedAt(page, 203, 125), OCCUPIED, 'the rectangle');
    assert.equal(await editedAt(page, 212, 125), FREE, 'the polygon over it');
    assert.equal(await editedAt(page, 201, 111), 0, 'what is cleared');
    assert.equal(await editedAt(page, 240, 240), FREE, 'the corner of what was filled');
    assert.equal(await editedAt(page, 239, 240), 0, 'and nothing beside it');

    // Only cells that are occupied become free: the wall, and not the unknown around the map.
    await page.getByRole('group', { name: 'Only cells that are now' }).getByLabel('occupied').check();
    await keys('b', ']', ']', ']');
    await lookAt(page, 300, 200, 3);
    await drag(page, [295, 200], [305, 200]);
    await stored(page);
    assert.equal(await editedAt(page, 300, 200), FREE);
    assert.equal(await editedAt(page, 298, 200), 0);

    // Esc gives a stroke up.
    const { x, y } = await screenOf(page, 250, 150);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 40, y);
    await keys('Escape');
    await page.mouse.up();
    const edits = await editsOf(system, draft);
    assert.equal(edits.length, 8);
    assert.ok(edits.every(({ author }) => author === 'Ann'));
    const { own, server } = await sameAsServer(page, system, draft);
    assert.deepEqual(own, server);
    const { mismatches, verified } = await statsOf(page);
    assert.ok(verified > 0, 'digests were compared');
    assert.equal(mismatches, 0);
    await picture(page, 'editor');
    assert.deepEqual(await faultsOf(page), []);
    await close();
  });

  test('edit_tools: all of it by the keyboard alone', async () => {
    const map = await newMap(system, 'keyboard');
    const { page, close } = await open(browser(), at(`${SITE}/maps/keyboard`));
    await page.getByRole('link', { name: 'Edit', exact: true }).focus();
    await page.keyboard.press('Enter');
    await introduce(page, 'Kim');
    await page.getByLabel('Name').fill('By keys');
    await page.keyboard.press('Enter');
    await stored(page);
    const { drafts: [{ name: draft }] } = await system.call(`${map}/drafts`);
    await page.keyboard.press('2');
    await page.getByText('Draw by numbers', { exact: true }).focus();
    await page.keyboard.press('Enter');
    const form = page.getByRole('form', { name: 'Draw by numbers' });
    const draw = async (shape, measure, text) => {
      await form.getByLabel('Shape').selectOption(shape);
      await form.getByLabel('Measured in').selectOption(measure);
      await form.getByRole('textbox').fill(text);
      await page.keyboard.press('Enter');
    };
    await page.getByLabel('cells across').selectOption('1');
    await draw('line', 'cells', '10, 20; 40, 20');
    await page.getByRole('status').getByText('Drawn: line.').waitFor();
    await draw('rectangle', 'metres', '5, 5; 6, 5.5'); // cells of 5 cm
    await draw('polygon', 'cells', '0, 0; 9, 9; 9, 0; 0, 9');
    await page.getByRole('alert').getByText('Sides 1 and 3 cross').waitFor();
    assert.equal(await editedAt(page, 25, 20), OCCUPIED);
    assert.equal(await editedAt(page, 119, 109), OCCUPIED);
    assert.equal(await editedAt(page, 120, 105), 0);
    await draw('fill', 'cells', '200, 200');
    await stored(page);
    assert.equal(await editedAt(page, 200, 300), OCCUPIED, 'the room is filled');
    await page.getByRole('button', { name: 'Undo' }).focus();
    await page.keyboard.press('Enter');
    await stored(page);
    assert.equal(await editedAt(page, 200, 300), 0);
    await page.keyboard.press('Control+s');
    const dialog = page.getByRole('dialog', { name: 'Publish the draft' });
    await dialog.getByText(/cells become occupied/).waitFor();
    await dialog.getByLabel('What was edited, and why').fill('A shelf');
    assert.deepEqual(await faultsOf(page), []);
    await picture(page, 'editor-publish');
    await page.keyboard.press('Enter');
    await dialog.getByText('Published:').waitFor();
    const [newest] = await revisionsOf(system, map);
    assert.equal(newest.source, 'SOURCE_EDIT');
    await dialog.getByRole('link', { name: /revision/ }).click();
    await page.getByText('Downloads').or(page.getByRole('heading', { name: 'Download' })).first().waitFor();
    const { draft: { state, message } } = await system.call(draft);
    assert.deepEqual([state, message], ['STATE_PUBLISHED', 'A shelf']);
    await close();
  });

  test('edit_tools: the list of drafts and the editor fit a phone, in both themes', async () => {
    const map = await newMap(system, 'phone');
    const draft = await newDraft(system, map, 'On a phone');
    for (const theme of ['light', 'dark']) {
      const { page, close } = await open(browser(), at(`${SITE}/maps/phone/edit`), { theme, width: 390, height: 780 });
      await introduce(page, 'Ann');
      await page.getByRole('table', { name: 'Drafts' }).getByRole('link', { name: 'On a phone' }).waitFor();
      for (const address of [undefined, editorAddress(system, draft)]) {
        if (address) await page.goto(address);
        if (address) await stored(page);
        assert.ok(await page.evaluate(() => document.querySelector('main').scrollWidth <= innerWidth), 'nothing sticks out');
        assert.deepEqual(await faultsOf(page), [], theme);
        await picture(page, `${address ? 'editor' : 'drafts'}-phone-${theme}`);
      }
      await close();
    }
  });

  test('edit_tools: drawing on a map of 4,000 x 4,000 cells', async (t) => {
    await importMap(system, SITE, 'large', pgmOf(4000, 4000, (x, y) => x % 250 === 0 || y % 250 === 0));
    const draft = await newDraft(system, `sites/${SITE}/maps/large`);
    const begin = Date.now();
    const { page, close } = await openEditor(browser(), system, draft, 'Ann');
    const loaded = Date.now() - begin;
    const tell = async (what) => {
      const times = (await statsOf(page)).frameMs.sort((a, b) => a - b);
      const share = (part) => times[Math.floor(times.length * part)].toFixed(1);
      t.diagnostic(`${what}: ${times.length} frames, scripts from pointer to picture p50 ${share(0.5)} ms, p95 ${share(0.95)} ms`);
      await page.evaluate(() => window.__editor.stats().frameMs.splice(0));
    };
    await page.evaluate(() => window.__editor.stats().frameMs.splice(0));
    await page.keyboard.press('2');
    const wave = (n) => Array.from({ length: n }, (_, i) => [600 + 12 * i, 2000 + 800 * Math.sin(i / 12)]);
    await drag(page, ...wave(200));
    await tell('all in view');
    await lookAt(page, 2000, 2000, 2);
    await page.evaluate(() => window.__editor.stats().frameMs.splice(0));
    await drag(page, ...Array.from({ length: 200 }, (_, i) => [1850 + 1.5 * i, 2000 + 100 * Math.sin(i / 12)]));
    await tell('two pixels a cell');
    await stored(page);
    const { tiles, mismatches } = await statsOf(page);
    t.diagnostic(`${tiles.all} tiles in ${loaded} ms`);
    assert.equal(tiles.all, 256);
    assert.equal(mismatches, 0);
    await close();
  });
}

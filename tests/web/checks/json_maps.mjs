// SPDX-License-Identifier: Apache-2.0
// Maps that other programs share as JSON (docs/map_files.md): imported, edited and exported without a loss.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultsOf, open, picture } from '../browser.mjs';
import { drag, editedAt, introduce, lookAt, publish, random, send, statsOf, stored } from '../editing.mjs';

const SITE = 'json';
const SIDE = 401; // cells: 6 m at 0.015 m, limits at the centres of the outer ones

// As a robot's program makes it: hits are counted, divided by the level and cut at 1, and later smoothed by an editor.
function shared() {
  const next = random(2);
  const data = Array.from({ length: SIDE * SIDE }, (_, i) => {
    const [column, row] = [i % SIDE, Math.floor(i / SIDE)];
    if (column < 20 || row < 20 || column >= SIDE - 20 || row >= SIDE - 20) return 0;
    if (Math.abs(column - 200) < 2 && row < 300) return 1;
    return 0.1408478733304343 + next(1000) * 1.0e-8;
  });
  // What the thresholds are about, in squares of 10 x 10.
  [0.2499, 0.26, 0.5, 0.64, 0.65, 0.29489240868472].forEach((value, i) => {
    for (let y = 0; y < 10; ++y) for (let x = 0; x < 10; ++x) data[(100 + y) * SIDE + 30 + 20 * i + x] = value;
  });
  return { xmin: -3, xmax: 3, ymin: -3, ymax: 3, stepx: 0.015, stepy: 0.015, level: 10, data };
}

const exported = async (system, map) => {
  const { files: [{ path }] } = await (await fetch(`${system.url}/v1/${map}/files?format=json`)).json();
  return (await fetch(`${system.url}${path}`)).json();
};

const seenAt = (page, column, row) => page.evaluate(([c, r]) => window.__editor.cell(r, c) & 3, [column, row]);

export function addJsonMaps({ system, browser, at }) {
  test('json_maps: a shared map is imported, edited and exported, and only what was drawn is another number', async () => {
    system.enfilade(SITE, 'site', 'create', SITE);
    const original = shared();
    const { page, close } = await open(browser(), at(`${SITE}/maps?import=1`), { expected: /Failed to load resource/ });
    const form = page.getByRole('form', { name: 'Import a map' });
    await form.getByLabel('Files').setInputFiles([{ name: 'map.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(original, undefined, 1)) }]);
    await form.getByLabel('Name').fill('Shared');
    await form.getByRole('button', { name: 'Import', exact: true }).click();
    await form.getByText('Imported:').waitFor();
    const map = (await system.call(`sites/${SITE}/maps`)).maps[0].name;
    const { revisions: [imported] } = await system.call(`${map}/revisions`);
    assert.deepEqual([imported.width, imported.height, imported.resolutionM], [SIDE, SIDE, 0.015]);
    const { x, y } = imported.poseMapGrid;
    assert.ok(Math.abs(x + 3.0075) < 1e-12 && Math.abs(y + 3.0075) < 1e-12, 'the limits are the centres of the outer cells');
    assert.deepEqual(await exported(system, map), original, 'each number is the same double');

    await form.getByRole('link', { name: 'Shared' }).click();
    await page.getByRole('link', { name: 'Edit', exact: true }).click();
    await introduce(page, 'Ann');
    await page.getByLabel('Name').fill('Walls');
    await page.keyboard.press('Enter');
    await stored(page);
    // The picture is by the thresholds that the page tells.
    const [, occupied, free] = /occupied from (\d+) %, free up to (\d+) %, and unknown between/.exec(await page.getByText(/counts as occupied from/).innerText()).map(Number);
    assert.deepEqual([occupied, free], [65, 25]);
    for (const [i, value] of [0.2499, 0.26, 0.5, 0.64, 0.65, 0.29489240868472].entries()) {
      assert.equal(await seenAt(page, 35 + 20 * i, 105), value >= occupied / 100 ? 2 : value <= free / 100 ? 1 : 0, `${value}`);
    }
    assert.equal(await seenAt(page, 300, 300), 1, '0.1408 is free');
    await lookAt(page, 200, 200, 3);
    const box = await page.locator('.edit-canvas').boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.getByText('cell 200, 199: occupied').or(page.getByText('cell 200, 200: occupied')).waitFor();

    // A wall is drawn, another one erased, and "unknown" is refused: these files have no number for it.
    await page.keyboard.press('2');
    await drag(page, [240, 150], [280, 190]);
    await page.keyboard.press('1');
    await drag(page, [200, 150], [200, 180]);
    await stored(page);
    await page.keyboard.press('3');
    await drag(page, [150, 200], [160, 200]);
    await page.getByRole('alert').getByText(/The server does not take an edit, so it was taken back: .*JSON/).waitFor();
    await stored(page);
    assert.equal(await editedAt(page, 155, 200), 0);
    assert.deepEqual(await faultsOf(page), []);
    await picture(page, 'json-map');
    const drawn = await page.evaluate((side) => Array.from({ length: side * side }, (_, i) => (window.__editor.cell(Math.floor(i / side), i % side) >> 2) & 3), SIDE);
    assert.ok([2, 3].every((one) => drawn.filter((value) => value === one).length > 80));
    const dialog = await publish(page, 'a wall more, a wall less');
    await dialog.getByText(/become/).first().waitFor();
    await send(dialog);
    await dialog.getByText('Published:').waitFor();
    const after = await exported(system, map);
    assert.deepEqual({ ...after, data: [] }, { ...original, data: [] }, 'limits, steps and level are those of the file');
    after.data.forEach((value, i) => assert.equal(value, drawn[i] === 3 ? 1 : drawn[i] === 2 ? 0 : original.data[i], `cell ${i % SIDE}, ${Math.floor(i / SIDE)}`));
    assert.equal((await statsOf(page)).mismatches, 0);
    await close();
  });
  // The same work says 20 in another place, and its cells reach half a step beyond the limits.
  test('json_maps: limits at the outer edges and a Level are read, too', async () => {
    system.enfilade(SITE, 'map', 'create', 'Edges');
    const map = (await system.call(`sites/${SITE}/maps`)).maps.find(({ displayName }) => displayName === 'Edges').name;
    const { level, ...rest } = { ...shared(), xmin: -3.0075, xmax: 3.0075, ymin: -3.0075, ymax: 3.0075 };
    const form = new FormData();
    form.append('file', new Blob([JSON.stringify({ ...rest, Level: 2 * level })]), 'map.json');
    const answer = await fetch(`${system.url}/v1/${map}:import`, { method: 'POST', body: form });
    assert.ok(answer.ok, await answer.text());
    const { width, height, poseMapGrid: { x, y } } = (await system.call(`${map}/revisions`)).revisions[0];
    assert.deepEqual([width, height], [SIDE, SIDE]);
    assert.ok(Math.abs(x + 3.0075) < 1e-12 && Math.abs(y + 3.0075) < 1e-12);
    assert.deepEqual(await exported(system, map), { ...rest, level: 2 * level });
  });
}

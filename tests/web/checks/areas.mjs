// SPDX-License-Identifier: Apache-2.0
// Areas that are drawn and edited in the browser, against the database, the files for robots, and other people.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultsOf, picture } from '../browser.mjs';
import { click, lookAt, newDraft, newMap, openEditor } from '../editing.mjs';
import { CELL_M } from '../maps.mjs';
import { distance } from '../pixels.mjs';
import { until } from '../system.mjs';

const [WIDTH, HEIGHT] = [600, 400]; // of the maps that `newMap` makes
const TRIANGLE = [[120, 120], [200, 120], [160, 200]]; // cells
const metresOf = ([column, row]) => ({ x: (column + 0.5) * CELL_M, y: (row + 0.5) * CELL_M });

const fitsIn = (page) => page.getByRole('complementary', { name: 'Details' }).evaluate((panel) => panel.scrollWidth <= panel.clientWidth);

const areasOf = async (system, map) => (await system.call(`${map}/areas`)).areas ?? [];

async function patch(system, area, fields) {
  const answer = await fetch(`${system.url}/v1/${area.name}?updateMask=${Object.keys(fields)}`, { method: 'PATCH', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ ...fields, etag: area.etag }) });
  assert.ok(answer.ok, await answer.clone().text());
  return (await answer.json()).area;
}

// How far a convex polygon and the square of a cell are apart; negative: how far they lie over one another.
function gapOf(corners, column, row) {
  const square = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([dx, dy]) => ({ x: (column + dx) * CELL_M, y: (row + dy) * CELL_M }));
  const sides = (ring) => ring.map((a, i) => { const b = ring[(i + 1) % ring.length]; const length = distance(a, b); return { x: (b.y - a.y) / length, y: (a.x - b.x) / length }; });
  const along = (ring, { x, y }) => ring.map((point) => point.x * x + point.y * y);
  return Math.max(...[...sides(corners), ...sides(square)].map((axis) => {
    const [a, b] = [along(corners, axis), along(square, axis)];
    return Math.max(Math.min(...a) - Math.max(...b), Math.min(...b) - Math.max(...a));
  }));
}

// The mask of keep-out areas as Nav2 reads it in mode raw: its values by row and column from the lower left.
async function maskOf(system, map, query) {
  const { files } = await (await fetch(`${system.url}/v1/${map}/areas/files?format=nav2-keepout${query}`)).json();
  const fetched = async (suffix) => Buffer.from(await (await fetch(`${system.url}${files.find(({ name }) => name.endsWith(suffix)).path}`)).arrayBuffer());
  const yaml = (await fetched('.yaml')).toString();
  assert.match(yaml, /^mode: raw$/m);
  const pgm = await fetched('.pgm');
  const [head, width, height] = /^P5\s+(?:#[^\n]*\n)*(\d+)\s+(\d+)\s+\d+\s/.exec(pgm.subarray(0, 400).toString('latin1'));
  assert.deepEqual([Number(width), Number(height)], [WIDTH, HEIGHT]);
  return (column, row) => pgm[head.length + (HEIGHT - 1 - row) * WIDTH + column];
}

function assertMask(mask, corners) {
  let inside = 0;
  for (let row = 0; row < HEIGHT; ++row) {
    for (let column = 0; column < WIDTH; ++column) {
      const gap = corners.length === 0 ? Infinity : gapOf(corners, column, row);
      if (Math.abs(gap) < 1e-6) continue; // it only touches
      inside += gap < 0 ? 1 : 0;
      assert.equal(mask(column, row), gap < 0 ? 100 : 0, `cell ${column}, ${row}`);
    }
  }
  return inside;
}

// Draws the triangle with the tool, and fills in the form.
async function drawTriangle(page, name, types) {
  await lookAt(page, 180, 160, 3);
  await page.keyboard.press('a');
  for (const [column, row] of TRIANGLE) await click(page, column, row);
  await page.keyboard.press('Enter');
  const form = page.getByRole('form', { name: 'New area' });
  await form.getByLabel('Name').fill(name);
  await form.getByLabel('Robot types').fill(types);
  await form.getByRole('button', { name: 'Create', exact: true }).click();
}

const list = (page) => page.getByRole('region', { name: 'Areas' });
const corner = (page, i) => page.getByRole('group', { name: 'Outline of the area' }).getByRole('button', { name: new RegExp(`^Corner ${i} at `) });

async function edit(page, name) {
  const row = list(page).getByRole('button', { name: new RegExp(`^${name}`) });
  await row.waitFor();
  if ((await row.getAttribute('aria-pressed')) === 'false') await row.click();
  await list(page).getByRole('button', { name: 'Edit', exact: true }).click();
  return page.getByRole('form', { name: `Edit ${name}` });
}

export function addAreas({ system, browser }) {
  test('keepout: an area that is drawn is in the database, the GeoJSON and the mask of the robots that it is for', async () => {
    const map = await newMap(system, 'areas');
    const { page, close } = await openEditor(browser(), system, await newDraft(system, map), 'Ann');
    await drawTriangle(page, 'Lab', 'cleaner, tug');
    await list(page).getByRole('button', { name: /Lab/ }).waitFor();
    const [area] = await areasOf(system, map);
    assert.deepEqual([area.kind, area.displayName, area.robotTypes], ['KIND_KEEP_OUT', 'Lab', ['cleaner', 'tug']]);
    const { corners } = area.outline;
    corners.forEach((at, i) => assert.ok(distance(at, metresOf(TRIANGLE[i])) < 0.03, `corner ${i} is where it was clicked: ${at.x}, ${at.y}`));
    assert.deepEqual(await faultsOf(page), []);

    const geojson = await (await fetch(`${system.url}/v1/${map}/areas/files/areas.geojson`)).json();
    const [{ id, geometry, properties }] = geojson.features;
    assert.equal(`${map}/${id}`, area.name);
    assert.deepEqual(geometry.coordinates[0].slice(0, -1).map(([x, y]) => ({ x, y })), corners);
    assert.deepEqual(properties.robot_types, ['cleaner', 'tug']);

    for (const type of ['cleaner', 'tug']) assert.ok(assertMask(await maskOf(system, map, `&robotType=${type}`), corners) > 3000, type);
    assertMask(await maskOf(system, map, '&robotType=forklift'), []);
    assertMask(await maskOf(system, map, ''), corners);

    await list(page).getByRole('button', { name: /Lab/ }).click();
    await list(page).getByRole('button', { name: 'Delete', exact: true }).click();
    await list(page).getByRole('button', { name: 'Delete it' }).click();
    await until('it is gone', async () => (await areasOf(system, map)).length === 0);
    await close();
  });

  test('keepout: corners are dragged, added and taken away, and kind, robots and times are changed', async () => {
    const map = await newMap(system, 'outline');
    const { page, close } = await openEditor(browser(), system, await newDraft(system, map), 'Ann');
    await drawTriangle(page, 'Ramp', '');
    const form = await edit(page, 'Ramp');
    const [before] = await areasOf(system, map);
    await lookAt(page, 180, 160, 3);
    const middleOf = async (locator) => { const { x, y, width, height } = await locator.boundingBox(); return { x: x + width / 2, y: y + height / 2 }; };
    const pull = async (locator, dx, dy) => {
      const { x, y } = await middleOf(locator);
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + dx / 2, y + dy / 2);
      await page.mouse.move(x + dx, y + dy);
      await page.mouse.up();
    };
    await pull(corner(page, 3), 60, -30); // 20 cells right, 10 up
    await pull(page.getByRole('button', { name: /^Side 1\./ }), 0, 45); // a corner in its middle, 15 cells down
    await form.getByLabel('Kind').selectOption('Speed limit');
    await form.getByLabel('Speed limit, m/s').fill('0.4');
    await form.getByLabel('Robot types').fill('forklift');
    await form.getByLabel('Valid from').fill('2026-12-01T08:00');
    await form.getByLabel('Valid until').fill('2026-12-01T07:00');
    await form.getByRole('button', { name: 'Save' }).click();
    await form.getByRole('alert').getByText('It ends before it begins').waitFor();
    await form.getByLabel('Valid until').fill('2026-12-31T18:00');
    assert.deepEqual(await faultsOf(page), []);
    assert.ok(await fitsIn(page), 'nothing sticks out of the panel');
    await picture(page, 'area-form');
    await form.getByRole('button', { name: 'Save' }).click();
    await form.waitFor({ state: 'detached' });
    const [after] = await areasOf(system, map);
    assert.deepEqual([after.kind, after.speedLimitMps, after.robotTypes, after.displayName], ['KIND_SPEED_LIMIT', 0.4, ['forklift'], 'Ramp']);
    assert.deepEqual([after.validFrom, after.validUntil].map((time) => Date.parse(time)), [Date.parse('2026-12-01T08:00'), Date.parse('2026-12-31T18:00')]);
    const [a, b, c] = before.outline.corners;
    const wanted = [a, { x: (a.x + b.x) / 2, y: a.y - 15 * CELL_M }, b, { x: c.x + 20 * CELL_M, y: c.y + 10 * CELL_M }];
    assert.equal(after.outline.corners.length, 4);
    after.outline.corners.forEach((at, i) => assert.ok(distance(at, wanted[i]) < 0.02, `corner ${i}: ${JSON.stringify(at)}, expected ${JSON.stringify(wanted[i])}`));
    assert.deepEqual([after.outline.corners[0], after.outline.corners[2]], [a, b], 'those that were not touched keep all their digits');
    assertMask(await maskOf(system, map, ''), []);

    // A keep-out area again: it is in the mask only while it holds.
    const again = await edit(page, 'Ramp');
    await again.getByLabel('Kind').selectOption('Keep out');
    await again.getByLabel('Corners, m').fill('5, 5; 10, 5; 10, 8; 5, 8');
    await again.getByRole('button', { name: 'Save' }).click();
    await again.waitFor({ state: 'detached' });
    const square = [{ x: 5, y: 5 }, { x: 10, y: 5 }, { x: 10, y: 8 }, { x: 5, y: 8 }];
    assert.deepEqual((await areasOf(system, map))[0].outline.corners, square);
    const at = (time) => `&robotType=forklift&time=${new Date(time).toISOString()}`;
    assertMask(await maskOf(system, map, at('2026-12-15T12:00')), square);
    assertMask(await maskOf(system, map, at('2026-12-01T07:59')), []);
    assertMask(await maskOf(system, map, at('2026-12-31T18:00')), []);
    await close();
  });

  test('keepout: who edits an area that somebody else has changed meanwhile sees what, and loses nothing', async () => {
    const map = await newMap(system, 'both-areas');
    const { page, close } = await openEditor(browser(), system, await newDraft(system, map), 'Ann', { expected: /409/ });
    await drawTriangle(page, 'Lab', '');
    const form = await edit(page, 'Lab');
    await form.getByLabel('Robot types').fill('tug');
    const [area] = await areasOf(system, map);
    await patch(system, area, { displayName: 'Laboratory' });
    const refused = page.waitForResponse((response) => response.request().method() === 'PATCH');
    await form.getByRole('button', { name: 'Save' }).click();
    assert.equal((await refused).status(), 409);
    assert.deepEqual((await areasOf(system, map))[0].robotTypes ?? [], []);
    const notice = page.getByRole('alert', { name: 'Changed by somebody else: Lab' });
    await notice.getByText('Name: Lab, now Laboratory').waitFor();
    assert.deepEqual(await faultsOf(page), []);
    assert.ok(await fitsIn(page), 'nothing sticks out of the panel');
    await picture(page, 'area-conflict');
    await notice.getByRole('button', { name: 'Keep mine on top' }).click();
    const rebased = page.getByRole('form', { name: 'Edit Laboratory' });
    await rebased.getByRole('button', { name: 'Save' }).click();
    await rebased.waitFor({ state: 'detached' });
    const [both] = await areasOf(system, map);
    assert.deepEqual([both.displayName, both.robotTypes], ['Laboratory', ['tug']]);

    const dropped = await edit(page, 'Laboratory');
    await dropped.getByLabel('Name').fill('Mine');
    await patch(system, both, { robotTypes: ['cleaner'] });
    await dropped.getByRole('button', { name: 'Save' }).click();
    await page.getByRole('alert', { name: /^Changed by somebody else/ }).getByRole('button', { name: 'Load theirs, drop mine' }).click();
    await until('theirs is shown', async () => (await dropped.getByLabel('Name').inputValue()) === 'Laboratory' && (await dropped.getByLabel('Robot types').inputValue()) === 'cleaner');
    await close();
  });

  test('keepout: all of it by the keyboard alone', async () => {
    const map = await newMap(system, 'area-keys');
    const { page, close } = await openEditor(browser(), system, await newDraft(system, map), 'Kim');
    const press = async (locator, ...keys) => {
      await locator.focus();
      for (const key of keys) await page.keyboard.press(key);
    };
    await press(list(page).getByRole('button', { name: 'New area' }), 'Enter');
    await page.keyboard.type('Stairs'); // the name has the focus
    const created = page.getByRole('form', { name: 'New area' });
    await created.getByLabel('Corners, m').focus();
    await page.keyboard.type('2, 2; 4, 2; 4');
    await press(created.getByLabel('Name'), 'Enter');
    await created.getByRole('alert').getByText(/“4” is not a point/).waitFor();
    await press(created.getByLabel('Corners, m'), 'End');
    await page.keyboard.type(', 4; 2, 4');
    await press(created.getByLabel('Name'), 'Enter');
    const row = list(page).getByRole('button', { name: /^Stairs/ });
    await row.waitFor();
    await press(row, 'Enter');
    await press(list(page).getByRole('button', { name: 'Edit', exact: true }), 'Enter');
    await press(corner(page, 1), 'ArrowLeft', 'ArrowLeft', 'Shift+ArrowDown');
    await press(page.getByRole('button', { name: /^Side 2\./ }), 'Enter', 'ArrowRight'); // the new corner has the focus
    await press(corner(page, 5), 'Delete');
    assert.ok(await fitsIn(page), 'nothing sticks out of the panel');
    await picture(page, 'area-keys');
    await press(page.getByRole('form', { name: 'Edit Stairs' }).getByRole('button', { name: 'Save' }), 'Enter');
    await page.getByRole('form', { name: 'Edit Stairs' }).waitFor({ state: 'detached' });
    const [{ outline: { corners } }] = await areasOf(system, map);
    const wanted = [{ x: 2 - 2 * CELL_M, y: 2 - CELL_M / 10 }, { x: 4, y: 2 }, { x: 4 + CELL_M, y: 3 }, { x: 4, y: 4 }];
    assert.equal(corners.length, 4);
    corners.forEach((at, i) => assert.ok(distance(at, wanted[i]) < 1e-6, `corner ${i}: ${JSON.stringify(at)}`));
    await press(list(page).getByRole('button', { name: 'Delete', exact: true }), 'Enter');
    await press(list(page).getByRole('button', { name: 'Delete it' }), 'Enter');
    await until('it is gone', async () => (await areasOf(system, map)).length === 0);
    await close();
  });
}

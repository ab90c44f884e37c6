// SPDX-License-Identifier: Apache-2.0
// Edits and robots that go on mapping: what people have published stays, and an editor that is open shows what is new.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { faultsOf, picture } from '../browser.mjs';
import { drag, editedAt, lookAt, newDraft, openEditor, publish, readTiles, send, statsOf, stored } from '../editing.mjs';
import { downloaded } from '../maps.mjs';
import { until } from '../system.mjs';

const SITE = 'survives';
const FREE = 2; // what edits say
const [SEEN_FREE, SEEN_OCCUPIED] = [1, 2]; // what robots have seen

// What robots have seen of the cells in a box of the page.
const seenIn = (page, [left, bottom, width, height]) => page.evaluate(([x, y, w, h]) => Array.from({ length: h }, (_, j) => Array.from({ length: w }, (_, i) => window.__editor.cell(y + j, x + i) & 3)), [left, bottom, width, height]);

async function boxOf(system, draft) {
  const { box } = await system.call(`${draft}:readTiles`, {});
  return [box.firstColumn ?? 0, box.firstRow ?? 0, box.width, box.height];
}

// The middle of the first square of cells of which `holds` says so, by rows of what robots have seen.
function find(rows, [left, bottom], side, holds) {
  for (let y = 0; y + side < rows.length; y += 2) {
    for (let x = 0; x + side < rows[0].length; x += 2) {
      const square = rows.slice(y, y + side).flatMap((row) => row.slice(x, x + side));
      if (holds(square)) return [left + x + side / 2, bottom + y + side / 2];
    }
  }
  throw new Error('no such place');
}

const all = (square, value) => square.every((cell) => cell === value);
const share = (square, value) => square.filter((cell) => cell === value).length / square.length;

// Whether a cell of the draft's lattice is a wall in the map's newest revision.
async function wallsOf(system, map, draft) {
  const { lattice: { poseMapLattice: { x = 0, y = 0 } = {}, resolutionM } } = (await system.call(draft)).draft;
  const raster = await downloaded(system, map);
  assert.equal(raster.resolution, resolutionM);
  const shift = (from, to) => Math.round((from - to) / resolutionM);
  return (column, row) => raster.wall(column + shift(x, raster.origin.x), row + shift(y, raster.origin.y));
}

// The tiles of the page are the server's, byte by byte.
async function sameBytes(page, system, draft) {
  const { knownTiles } = await system.call(`${draft}:readTiles`, {});
  const tiles = await readTiles(system, draft, knownTiles);
  const own = await page.evaluate((places) => places.map(({ row = 0, column = 0 }) => Array.from({ length: 65536 }, (_, i) => window.__editor.cell(256 * row + (i >> 8), 256 * column + (i & 255)))), knownTiles);
  return tiles.every(({ cells }, i) => cells.equals(Buffer.from(own[i])));
}

export function addSurvivesMapping({ system, browser }) {
  test('survives_mapping: edits stay when robots map on, and an open editor shows what these see', async () => {
    system.enfilade(SITE, 'site', 'create', SITE);
    const log = join(system.folder, 'survives.jsonl');
    system.enfilade(SITE, '--quiet', 'simulate', '--laps', '1', '-o', log);
    // The first robot sees only a part.
    const lines = readFileSync(log, 'utf8').trimEnd().split('\n');
    const part = join(system.folder, 'survives-part.jsonl');
    writeFileSync(part, `${lines.slice(0, Math.round(0.4 * lines.length)).join('\n')}\n`);
    const drive = (file, name, ...where) => system.enfilade(SITE, '--quiet', 'replay', file, '--map', 'Rooms', '--session', name, '--spool', join(system.folder, `survives-${name}`), '--wait', ...where);
    drive(part, 'first');
    const map = (await system.call(`sites/${SITE}/maps`)).maps[0].name;

    // Ann erases a part of a wall, as if it were a ghost, and draws glass that scanners do not see.
    const edits = await newDraft(system, map, 'a ghost and glass');
    const ann = await openEditor(browser(), system, edits, 'Ann');
    const box = await boxOf(system, edits);
    const rows = await seenIn(ann.page, box);
    const ghost = find(rows, box, 12, (square) => share(square, SEEN_OCCUPIED) > 0.1);
    const glass = find(rows, box, 30, (square) => all(square, SEEN_FREE));
    const keys = async (...those) => { for (const key of those) await ann.page.keyboard.press(key); };
    await lookAt(ann.page, ...ghost, 4);
    await keys('b', '1', ']', ']', ']', ']', ']');
    await drag(ann.page, [ghost[0] - 4, ghost[1]], [ghost[0] + 4, ghost[1]]);
    await lookAt(ann.page, ...glass, 4);
    await keys('[', '[', '[', '[', '[', '[', '[', '2', 'l');
    await ann.page.getByLabel('Invisible to scanners').check();
    await drag(ann.page, [glass[0] - 10, glass[1]], [glass[0] + 10, glass[1]]);
    await stored(ann.page);
    const erased = [];
    const drawn = [];
    for (let row = box[1]; row < box[1] + box[3]; ++row) {
      for (const [column, value] of (await ann.page.evaluate(([r, c, n]) => Array.from({ length: n }, (_, i) => [c + i, (window.__editor.cell(r, c + i) >> 2) & 3]), [row, box[0], box[2]])).filter(([, edited]) => edited > 0)) (value === FREE ? erased : drawn).push([column, row]);
    }
    assert.ok(erased.length > 50 && drawn.length === 21, `${erased.length} cells are erased, ${drawn.length} drawn`);
    const before = await wallsOf(system, map, edits);
    assert.ok(erased.some((cell) => before(...cell)) && drawn.every((cell) => !before(...cell)));
    await picture(ann.page, 'survives-edits');
    const dialog = await publish(ann.page, 'a ghost, and glass');
    await dialog.getByText(/ 21 become occupied/).waitFor();
    await send(dialog);
    await dialog.getByText('Published:').waitFor();
    await ann.close();

    // Bob has another draft open, with a stroke in it, while a robot maps the whole.
    const draft = await newDraft(system, map, 'while robots map');
    const bob = await openEditor(browser(), system, draft, 'Bob');
    await bob.page.evaluate(() => (window.notReloaded = true));
    await lookAt(bob.page, ...glass, 3);
    await bob.page.keyboard.press('2');
    await drag(bob.page, [glass[0] - 5, glass[1] + 8], [glass[0] + 5, glass[1] + 8]);
    await stored(bob.page);
    const camera = await bob.page.evaluate(() => window.__editor.camera());
    const known = (cells) => cells.flat().filter((cell) => cell > 0).length;
    const knownBefore = known(await seenIn(bob.page, await boxOf(system, draft)));
    const start = (await (await fetch(`${system.url}/v1/sites/${SITE}/sessions/first/trajectory.csv`)).text()).split('\n')[1].split(',').slice(1);
    const numberOf = async () => Number((await system.call(map)).map.latestRevision.split('/').pop());
    const edited = await numberOf();
    drive(log, 'second', '--at', start.join(','));
    await system.call(`sites/${SITE}:optimize`, {});

    // Both edits are in the newest revision, over what the robots have seen.
    const newest = (await system.call(`${map}/revisions`)).revisions[0];
    assert.ok((await numberOf()) > edited && newest.source !== 'SOURCE_EDIT', `a robot has made ${newest.name}`);
    assert.equal(Number(newest.editVersion), 1);
    const after = await wallsOf(system, map, draft);
    for (const cell of erased) assert.ok(!after(...cell), `cell ${cell} stays erased`);
    for (const cell of drawn) assert.ok(after(...cell), `cell ${cell} stays drawn`);

    // Bob's page shows the same without being loaded again.
    await bob.page.getByText(`over revision ${await numberOf()}`).waitFor();
    await until('the page has what the server has', async () => {
      await stored(bob.page);
      return sameBytes(bob.page, system, draft);
    });
    const knownAfter = known(await seenIn(bob.page, await boxOf(system, draft)));
    assert.ok(knownAfter > 1.1 * knownBefore, `${knownBefore} cells were known, now ${knownAfter}`);
    assert.ok(await bob.page.evaluate(() => window.notReloaded));
    assert.deepEqual(await bob.page.evaluate(() => window.__editor.camera()), camera);
    assert.equal(await editedAt(bob.page, glass[0], glass[1] + 8), 3, 'what Bob has drawn is still there');
    assert.equal((await statsOf(bob.page)).mismatches, 0);
    await bob.page.keyboard.press('Control+z');
    await stored(bob.page);
    assert.equal(await editedAt(bob.page, glass[0], glass[1] + 8), 0, 'and he can undo it');

    // What was seen again is contested, the glass is not.
    const inbox = bob.page.getByRole('region', { name: 'Contested edits' });
    await inbox.getByText(/Ann made it free \(“a ghost, and glass”\); a robot saw it occupied since/).first().waitFor();
    const { contested } = await system.call(`${map}/contestedEdits`);
    assert.ok(contested.every(({ edited: says, session }) => says === 'VALUE_FREE' && session.endsWith('/second')));
    await inbox.getByRole('button', { name: 'Show', exact: true }).first().click();
    const { x, y } = await bob.page.evaluate(() => window.__editor.camera());
    assert.ok(Math.hypot(x - ghost[0], y - ghost[1]) < 15, 'it is the ghost that is shown');
    assert.deepEqual(await faultsOf(bob.page), []);
    await picture(bob.page, 'survives-contested');
    await bob.close();
  });
  test('survives_mapping: what is published while robots map is in every revision from then on', async (t) => {
    const site = 'publishing';
    system.enfilade(site, 'site', 'create', site);
    const log = join(system.folder, 'publishing.jsonl');
    system.enfilade(site, '--quiet', 'simulate', '--laps', '1', '-o', log);
    const drive = (name, ...where) => system.aside(site, 'publishing.log', '--quiet', 'replay', log, '--map', 'Rooms', '--session', name, '--spool', join(system.folder, `publishing-${name}`), '--wait', ...where);
    await drive('first');
    const map = (await system.call(`sites/${site}/maps`)).maps[0].name;
    const start = (await (await fetch(`${system.url}/v1/sites/${site}/sessions/first/trajectory.csv`)).text()).split('\n')[1].split(',').slice(1).join(',');
    const { width, height } = (await system.call(`${map}/revisions`)).revisions[0];
    let isOver = false;
    const mapping = (async () => { for (const name of ['second', 'third', 'fourth']) await drive(name, '--at', start); })().finally(() => (isOver = true));
    // One cell each, a row for all, outside of the rooms.
    const published = [];
    const lattices = new Set();
    while (!isOver) {
      const draft = await newDraft(system, map, `cell ${published.length}`);
      const { box } = await system.call(`${draft}:readTiles`, {});
      const cell = [(box.firstColumn ?? 0) + 2 + 2 * (published.length % Math.floor(width / 2 - 4)), (box.firstRow ?? 0) + 2 + 2 * Math.floor(published.length / Math.floor(width / 2 - 4))];
      const at = { x: 256 * cell[0] + 128, y: 256 * cell[1] + 128 };
      await system.call(`${draft}:append`, { edits: [{ editId: `00000000-0000-4000-8000-${String(published.length).padStart(12, '0')}`, author: 'Ann', value: 'VALUE_OCCUPIED', invisible: true, brush: { points: [at], radius: 1 } }] });
      const { revision, draft: after } = await system.call(`${draft}:publish`, { message: 'a cell', confirmWarnings: true });
      lattices.add(JSON.stringify(after.lattice));
      published.push({ cell, draft, number: Number(revision.name.split('/').pop()) });
    }
    await mapping;
    assert.equal(lattices.size, 1);
    const revisions = (await system.call(`${map}/revisions?pageSize=1000`)).revisions.map((one) => ({ ...one, number: Number(one.name.split('/').pop()) })).sort((a, b) => a.number - b.number);
    const mapped = revisions.filter(({ source, number }) => source === 'SOURCE_MAPPING' && number > 1);
    t.diagnostic(`${published.length} publications, and ${mapped.length} revisions of robots between them, of ${width} x ${height} cells`);
    assert.ok(mapped.length >= 3 && published.length > 10);
    for (const { number, editVersion } of revisions) assert.equal(Number(editVersion), published.filter((one) => one.number <= number).length, `revision ${number}`);
    for (const { name, number } of [...mapped, revisions.at(-1)]) {
      const wall = await wallsOf(system, name, published[0].draft);
      for (const one of published.filter((other) => other.number <= number)) assert.ok(wall(...one.cell), `revision ${number} has ${one.cell}, published as ${one.number}`);
    }
  });
}

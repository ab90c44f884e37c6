// SPDX-License-Identifier: Apache-2.0
// A floor plan, from its file to the walls under the maps.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, settled } from '../browser.mjs';
import { distance, look, pixelsOf, sceneOf, toScreen } from '../pixels.mjs';
import { until } from '../system.mjs';

const SITE = 'plans';

// A robot maps a building whose plan is drawn as people do.
function mapBuilding(system) {
  const folder = join(system.folder, 'building');
  system.enfilade(SITE, 'site', 'create', SITE);
  system.enfilade(SITE, '--quiet', 'simulate', 'random:7502', '--robots', 'robot', '-o', join(folder, 'drive'), '--plan-out', folder, '--plan-deform', '7502');
  system.enfilade(SITE, '--quiet', 'replay', join(folder, 'drive/robot/log.jsonl'), '--map', 'Building', '--spool', join(folder, 'spool'), '--wait');
  return { name: 'floor.png', mimeType: 'image/png', buffer: readFileSync(join(folder, 'plan-filled.png')) };
}

const planOf = async (system) => (await system.call(`sites/${SITE}/priorMaps`)).priorMaps[0];
const wallsOf = async (system) => {
  const { features } = await (await fetch(`${system.url}/v1/${(await planOf(system)).name}/files/walls.geojson`)).json();
  return features.filter(({ properties }) => properties.kind === 'wall');
};

export function addPlans({ system, browser, at }) {
  test('plans: a plan is imported, found in the maps, confirmed and drawn under them', async () => {
    const file = mapBuilding(system);
    const { page, close } = await open(browser(), at(`${SITE}/plans`));
    await page.getByRole('button', { name: 'Import a plan' }).click();
    const form = page.getByRole('form', { name: 'Import a plan' });
    await form.getByLabel('File').setInputFiles([file]);
    await form.getByLabel('Name').fill('Ground floor');
    await form.getByRole('button', { name: 'Import', exact: true }).click();
    await form.getByText('Imported:').waitFor();
    assert.equal((await planOf(system)).state, 'STATE_NEW');
    await form.getByRole('link', { name: 'Ground floor' }).click();
    await page.getByRole('button', { name: 'Align', exact: true }).click();
    await page.getByText(/^Accepted: /).waitFor({ timeout: 120_000 });
    assert.equal((await planOf(system)).state, 'STATE_PROPOSED');
    await page.getByRole('button', { name: 'Activate' }).click();
    await until('it is in use', async () => (await planOf(system)).state === 'STATE_ACTIVE');
    assert.deepEqual(await faultsOf(page), []);

    const unseen = (await wallsOf(system)).filter(({ properties }) => properties.state === 'unseen');
    assert.ok(unseen.length > 0, 'a part of the building is on the plan only');
    const longest = unseen.map(({ geometry: { coordinates: [[x0, y0], [x1, y1]] } }) => ({ length: Math.hypot(x1 - x0, y1 - y0), x: (x0 + x1) / 2, y: (y0 + y1) / 2 })).sort((a, b) => b.length - a.length)[0];
    await page.getByRole('link', { name: 'Show on the campus' }).click();
    await until('the map is drawn', async () => (await drawnMaps(page)).length === 1);
    await page.getByRole('button', { name: 'Show floor plans' }).waitFor();
    await look(page, { x: longest.x, y: longest.y, scale: 40 });
    const middle = async () => { const { at, width, height } = await pixelsOf(page); return at(Math.round(width / 2), Math.round(height / 2)); };
    const isBlue = ([red, , blue]) => blue > red + 60;
    await until('the wall is drawn', async () => isBlue(await middle()));
    await page.locator('.scene-canvas').press('p');
    await until('and hidden', async () => !isBlue(await middle()));
    await close();
  });

  test('plans: people show the place on two panes', async () => {
    const { name, alignment: { affineWorldSheet: [a, b, c, d, e, f] } } = await planOf(system);
    const toSheet = ({ x, y }) => ({ x: (e * (x - c) - b * (y - f)) / (a * e - b * d), y: (a * (y - f) - d * (x - c)) / (a * e - b * d) });
    const { page, close } = await open(browser(), at(`${SITE}/plans/${name.split('/').pop()}/points`));
    await until('the map is drawn', async () => (await drawnMaps(page)).length === 1);
    await settled(page);
    const { camera, size } = await sceneOf(page);
    const seen = (await wallsOf(system)).filter(({ properties }) => properties.state === 'seen').map(({ geometry: { coordinates: [[x, y]] } }) => ({ x, y }));
    const farthest = (from) => seen.reduce((best, one) => (Math.min(...from.map((p) => distance(p, one))) > Math.min(...from.map((p) => distance(p, best))) ? one : best));
    const places = [seen[0]];
    while (places.length < 3) places.push(farthest(places));
    const list = page.getByRole('list', { name: 'Pairs' });
    const image = page.getByRole('img', { name: 'The imported plan' });
    const natural = await image.evaluate(({ naturalWidth, naturalHeight }) => ({ width: naturalWidth, height: naturalHeight }));
    for (const [i, place] of places.entries()) {
      const { width, height } = await image.boundingBox();
      const sheet = toSheet(place);
      await image.click({ position: { x: ((sheet.x + 0.5) / natural.width) * width, y: ((sheet.y + 0.5) / natural.height) * height } });
      const screen = toScreen(camera, size, place);
      await page.locator('.scene-canvas').click({ position: { x: Math.round(screen.x), y: Math.round(screen.y) } });
      await until(`pair ${i + 1} is listed`, async () => (await list.getByRole('listitem').count()) === i + 1);
    }
    await page.getByText('Off the place that fits all pairs best:').waitFor();
    await page.getByRole('button', { name: 'Align by these points' }).click();
    await page.getByText(/^Accepted: /).waitFor({ timeout: 120_000 });
    const { pairs } = (await planOf(system)).alignment;
    assert.equal(pairs.length, 3);
    await page.getByText('Off the plan as it is aligned:').waitFor();
    pairs.forEach(({ sheetX, sheetY }, i) => assert.ok(distance({ x: sheetX, y: sheetY }, toSheet(places[i])) < 3 * (natural.width / 300), `pair ${i + 1} is where it was shown`));
    assert.equal(await list.getByText('off by').count(), 3);
    await page.getByRole('button', { name: 'Remove pair 2' }).click();
    await until('two are left', async () => (await list.getByRole('listitem').count()) === 2);
    assert.deepEqual(await faultsOf(page), []);
    await close();
  });
}

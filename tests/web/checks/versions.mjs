// SPDX-License-Identifier: Apache-2.0
// Aliases, differences and restored revisions of a map, by the dashboard.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, picture } from '../browser.mjs';
import { importMap, pgmOf } from '../maps.mjs';
import { distance, sceneOf } from '../pixels.mjs';
import { until } from '../system.mjs';

const SITE = 'versions';
const MAP = `sites/${SITE}/maps/hall`;
// Cells of the lower left corner of a pillar of 10 x 10.
const pillars = [[40, 40], [300, 120]];
const hallWith = ([left, bottom]) => pgmOf(400, 200, (x, y) => x === 0 || y === 0 || x === 399 || y === 199 || (x >= left && x < left + 10 && y >= bottom && y < bottom + 10));

// Revision 1 has a pillar, revision 2 another one instead.
async function twoRevisions(system) {
  system.enfilade(SITE, 'site', 'create', SITE);
  await importMap(system, SITE, 'hall', hallWith(pillars[0]), 'Hall');
  const form = new FormData();
  form.append('file', new Blob(['image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n']), 'm.yaml');
  form.append('file', new Blob([hallWith(pillars[1])]), 'm.pgm');
  const answer = await fetch(`${system.url}/v1/${MAP}:import`, { method: 'POST', body: form });
  assert.ok(answer.ok, await answer.text());
}

const aliasesOf = async (system) => (await system.call(`${MAP}/aliases`)).aliases;
const leadsTo = async (system, revision) => (await aliasesOf(system)).find(({ name }) => name.endsWith('/stable'))?.revision === `${MAP}/revisions/${revision}`;

export function addVersions({ system, browser, at }) {
  test('versions: what came and went is told in numbers, and shown where it is', async () => {
    await twoRevisions(system);
    const { page, close } = await open(browser(), at(`${SITE}/maps/hall?with=1`));
    await until('the map is drawn', async () => (await drawnMaps(page)).length > 0);
    const differences = page.getByRole('region', { name: 'Differences' });
    await differences.getByRole('heading', { name: 'From 1 to 2' }).waitFor();
    await page.getByText('2 places changed').waitFor();
    for (const title of ['Walls that came', 'Walls that went']) {
      const area = differences.locator('.difference', { hasText: title });
      await area.getByText('0.25 m²').waitFor(); // 100 cells of 0.05 m
      await area.getByText('100 cells').waitFor();
    }
    await differences.getByRole('button', { name: 'Occupied now' }).click();
    const middle = { x: (pillars[1][0] + 5) * 0.05, y: (pillars[1][1] + 5) * 0.05 };
    await until('the picture goes there', async () => distance((await sceneOf(page)).camera, middle) < 0.01);
    assert.deepEqual(await faultsOf(page), []);
    await picture(page, 'versions-difference');
    await close();
  });

  test('versions: an alias is set, moved and led back', async () => {
    const { page, close } = await open(browser(), at(`${SITE}/maps/hall?rev=1`));
    const aliases = page.getByRole('region', { name: 'Aliases' });
    await aliases.getByRole('button', { name: 'stable', exact: true }).click();
    await until('stable leads to revision 1', () => leadsTo(system, 1));
    await page.locator('.revision', { hasText: 'stable' }).getByText('1', { exact: true }).waitFor();
    await page.locator('.revision-show').first().click();
    await aliases.getByRole('button', { name: 'stable', exact: true }).click();
    await until('and now to revision 2', () => leadsTo(system, 2));
    await aliases.getByRole('button', { name: 'Back to 1' }).click();
    await aliases.getByRole('button', { name: 'Keep it' }).click();
    assert.ok(await leadsTo(system, 2), 'it asks first');
    await aliases.getByRole('button', { name: 'Back to 1' }).click();
    await aliases.getByRole('button', { name: 'Lead it back' }).click();
    await until('and to revision 1 again', () => leadsTo(system, 1));
    await aliases.getByRole('textbox', { name: 'Another alias' }).fill('Not a name');
    await aliases.getByRole('button', { name: 'Set' }).click();
    await aliases.getByRole('alert').getByText(/a-z, 0-9/).waitFor();
    assert.deepEqual(await faultsOf(page), []);
    await close();
  });

  test('versions: who moves an alias that somebody else has moved meanwhile is told so', async () => {
    const { page, close } = await open(browser(), at(`${SITE}/maps/hall`), { expected: /Failed to load resource/ });
    const aliases = page.getByRole('region', { name: 'Aliases' });
    await aliases.getByRole('button', { name: 'Back to 2' }).waitFor();
    system.enfilade(SITE, 'map', 'alias', 'set', 'Hall', 'stable', '--revision', '2');
    system.enfilade(SITE, 'map', 'alias', 'set', 'Hall', 'stable', '--revision', '1');
    await aliases.getByRole('button', { name: 'stable', exact: true }).click();
    await aliases.getByRole('alert').getByText(/has been changed meanwhile/).waitFor();
    assert.ok(await leadsTo(system, 1));
    await close();
  });

  test('versions: an older revision is restored', async () => {
    const { page, close } = await open(browser(), at(`${SITE}/maps/hall?rev=1`));
    await page.getByRole('button', { name: 'Restore revision 1' }).click();
    await page.getByRole('button', { name: 'Restore it' }).click();
    await until('it is the newest', async () => (await system.call(MAP)).map.latestRevision === `${MAP}/revisions/3`);
    await page.locator('.revision').first().getByText('Restored').waitFor();
    assert.equal((await system.call(`${MAP}/revisions/3`)).revision.source, 'SOURCE_RESTORED');
    await close();
  });
}

// SPDX-License-Identifier: Apache-2.0
// Maps that are imported in the browser, against what the server then has.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, picture } from '../browser.mjs';
import { CELL_M, downloaded, pgmOf } from '../maps.mjs';
import { until } from '../system.mjs';

const SIDE = 2000; // cells: 4 MB
const isWall = (x, y) => x === 0 || y === 0 || x === SIDE - 1 || y === SIDE - 1 || (x === 700 && y > 300);

const yaml = (image) => `image: ${image}\nresolution: ${CELL_M}\norigin: [-1.5, 2.5, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n`;
const filesOf = (image, pgm) => [
  { name: 'hall.yaml', mimeType: 'application/yaml', buffer: Buffer.from(yaml(image)) },
  { name: 'hall.pgm', mimeType: 'image/x-portable-graymap', buffer: pgm },
];
const large = filesOf('hall.pgm', pgmOf(SIDE, SIDE, isWall));

// As over a slow network, so that there is something to see of an upload.
async function slowDown(page, uploadBytesPerSecond) {
  const client = await page.context().newCDPSession(page);
  await client.send('Network.enable');
  await client.send('Network.emulateNetworkConditions', { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: uploadBytesPerSecond });
}

const mapsOf = async (system) => (await system.call('sites/imports/maps')).maps ?? [];

export function addImports({ system, browser, at }) {
  test('import: a map is uploaded with progress, and is what the file says', async () => {
    system.enfilade('imports', 'site', 'create', 'imports');
    const { page, close } = await open(browser(), at('imports/maps'));
    await page.getByRole('button', { name: 'Import a map' }).focus();
    await page.keyboard.press('Enter');
    const form = page.getByRole('form', { name: 'Import a map' });
    const submit = form.getByRole('button', { name: 'Import', exact: true });
    await submit.click();
    await form.getByRole('alert').getByText('Choose the files of the map.').waitFor();
    await form.getByLabel('Files').setInputFiles(large.slice(0, 1));
    await submit.click();
    await form.getByRole('alert').getByText(/The image is missing/).waitFor();
    await form.getByLabel('Files').setInputFiles(large);
    await form.getByLabel('Name').fill('Great hall');
    await form.getByLabel('Level').fill('2');
    await slowDown(page, 2_000_000);
    await page.keyboard.press('Enter'); // in the field of the level
    const shares = [];
    await until('it is imported', async () => {
      shares.push(await page.evaluate(() => { const bar = document.querySelector('progress'); return bar ? bar.value / bar.max : undefined; }));
      return form.getByText('Imported:').isVisible();
    });
    assert.ok(shares.some((share) => share > 0 && share < 1), `the progress is shown on its way: ${shares}`);
    const [map] = await mapsOf(system);
    assert.equal(map.displayName, 'Great hall');
    assert.equal(map.level, 2);
    const raster = await downloaded(system, map.name);
    const { x, y } = raster.origin;
    assert.deepEqual({ x, y }, { x: -1.5, y: 2.5 });
    for (let row = 0; row < SIDE; row += 7) for (let column = 0; column < SIDE; column += 7) assert.equal(raster.wall(column, row), isWall(column, row), `cell ${column}, ${row}`);
    await form.getByRole('link', { name: 'Great hall' }).click();
    await until('its page draws it', async () => (await drawnMaps(page)).some(({ name }) => name === map.name));
    await close();
  });

  test('import: into a map that exists it makes a new revision', async () => {
    const [map] = await mapsOf(system);
    const { page, close } = await open(browser(), at('imports/maps?import=1'));
    const form = page.getByRole('form', { name: 'Import a map' });
    await form.getByLabel('Into').selectOption(map.name);
    await form.getByLabel('Files').setInputFiles(filesOf('hall.pgm', pgmOf(100, 100, (x) => x === 50)));
    await form.getByRole('button', { name: 'Import', exact: true }).click();
    await form.getByText('Imported:').waitFor();
    const { revisions } = await system.call(`${map.name}/revisions`);
    assert.equal(revisions.length, 2);
    assert.equal(revisions[0].width, 100);
    await close();
  });

  test('import: one that is cancelled stores nothing', async () => {
    const before = await mapsOf(system);
    const { page, close } = await open(browser(), at('imports/maps?import=1'));
    const form = page.getByRole('form', { name: 'Import a map' });
    await form.getByLabel('Files').setInputFiles(large);
    await form.getByLabel('Name').fill('Never');
    await slowDown(page, 200_000);
    await form.getByRole('button', { name: 'Import', exact: true }).click();
    await until('a part has been sent', () => page.evaluate(() => document.querySelector('progress')?.value > 0));
    await picture(page, 'import-progress');
    assert.deepEqual(await faultsOf(page), []);
    await form.getByRole('button', { name: 'Cancel' }).click();
    await form.getByRole('alert').getByText('Cancelled: nothing was stored.').waitFor();
    assert.deepEqual(await mapsOf(system), before);
    await close();
  });

  test('import: what the server refuses is told in its words, and leaves no map behind', async () => {
    const before = await mapsOf(system);
    const wrong = filesOf('other.pgm', pgmOf(10, 10, () => false));
    for (const theme of ['light', 'dark']) {
      const { page, close } = await open(browser(), at('imports/maps?import=1'), { theme, width: 390, height: 780, expected: /Failed to load resource/ });
      const form = page.getByRole('form', { name: 'Import a map' });
      await form.getByLabel('Files').setInputFiles(wrong);
      await form.getByLabel('Name').fill('Refused');
      const answer = page.waitForResponse((response) => response.url().endsWith(':import'));
      await form.getByRole('button', { name: 'Import', exact: true }).click();
      const refused = await answer;
      assert.equal(refused.status(), 400);
      const { message } = await refused.json();
      await form.getByRole('alert').getByText(message).waitFor();
      assert.ok(await page.evaluate(() => document.querySelector('main').scrollWidth <= innerWidth), 'nothing sticks out');
      assert.deepEqual(await faultsOf(page), [], theme);
      await picture(page, `import-refused-${theme}`);
      await close();
    }
    assert.deepEqual(await mapsOf(system), before);
  });
}

// SPDX-License-Identifier: Apache-2.0
// What holds of every page.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, picture, settled } from '../browser.mjs';
import { twoRooms } from '../maps.mjs';
import { folder, picturesOf, root, show, storedStructures, structureOf, viewport } from '../pictures.mjs';
import { pixelsOf, sceneOf, toScreen } from '../pixels.mjs';
import { until } from '../system.mjs';

const LARGEST = 200_000; // bytes of a picture

// The pictures that a document of the repository shows, by their names.
const shownBy = (document) => [...readFileSync(join(root, document), 'utf8').matchAll(/!\[[^\]]*\]\(([^)]*images\/dashboard\/([^)]*)\.png)\)/g)].map(([, , name]) => name);

export function addPages({ system, browser, at, campus }) {
  test('security: names of HTML and of scripts are text', async () => {
    system.enfilade('odd', 'site', 'create', 'odd', '--name', '<img src=x onerror=alert(1)>');
    const names = ['<script>window.executed = 1</script>', '<img src=x onerror="window.executed = 1">', 'javascript:window.executed=1'];
    for (const displayName of names) await system.call('sites/odd/maps', { displayName });
    for (const path of ['odd/maps', 'odd/campus']) {
      const { page, close } = await open(browser(), at(path));
      if (path === 'odd/maps') for (const name of names) await page.getByText(name, { exact: true }).first().waitFor();
      else await page.locator('main').getByText(/./).first().waitFor();
      assert.equal(await page.evaluate(() => window.executed), undefined);
      for (const href of await page.locator('a').evaluateAll((links) => links.map((link) => link.href))) assert.match(href, /^http:/);
      await close();
    }
  });

  test('a11y: axe finds nothing serious on any page in either theme', async () => {
    await campus();
    const first = await open(browser(), at('demo/campus'));
    const links = first.page.getByRole('navigation', { name: 'Pages' }).locator('a.rail-link');
    await links.first().waitFor();
    const paths = await links.evaluateAll((all) => all.map((link) => new URL(link.href).pathname));
    await first.close();
    for (const theme of ['light', 'dark']) {
      for (const path of [...paths, '/s/demo/history/versions', '/s/demo/history/audit', '/s/demo/history/rearranged', '/s/demo/linkPoints/candidates', '/s/demo/campus?edit=graph', '/', '/s/empty/campus', '/s/empty/maps']) {
        const { page, close } = await open(browser(), system.url + path, { theme });
        await settled(page);
        await picture(page, `page${path.replaceAll(/[/?=]/g, '-')}-${theme}`);
        assert.deepEqual(await faultsOf(page), [], `${path}, ${theme}`);
        await close();
      }
    }
  });

  test('appearance: themes and colours of maps are chosen at once and kept', async () => {
    await twoRooms(system, 'colours');
    const { page, close } = await open(browser(), at('colours/campus'));
    await until('both maps are drawn', async () => (await drawnMaps(page)).length === 2);
    await settled(page);
    const { camera, size } = await sceneOf(page);
    const { x, y } = toScreen(camera, size, { x: 3, y: 7 }); // free space of map a
    const floor = async () => {
      await settled(page);
      const [red, green, blue] = (await pixelsOf(page)).at(Math.round(x), Math.round(y));
      return red + green + blue;
    };
    const button = page.getByRole('button', { name: 'Appearance' });
    const choose = async (name) => {
      await button.focus();
      await page.keyboard.press('Enter');
      await page.getByRole('radio', { name }).check();
      await page.keyboard.press('Escape');
    };
    assert.ok((await floor()) > 3 * 240, 'free space is bright');
    await choose('Dark');
    await until('the map is dark', async () => (await floor()) < 3 * 80);
    await choose('High contrast');
    await until('free space is black', async () => (await floor()) < 3 * 6);
    await page.reload();
    await until('both maps are drawn again', async () => (await drawnMaps(page)).length === 2);
    await until('the choice is kept', async () => (await floor()) < 3 * 6);
    await button.click();
    assert.deepEqual(await faultsOf(page), []);
    await picture(page, 'appearance');
    await page.keyboard.press('Escape');
    for (const name of ['Grey, as robots’ tools show maps', 'Safe for colour blindness']) {
      await choose(name);
      await settled(page);
      await picture(page, `colours-${name.split(/[ ,]/)[0].toLowerCase()}`);
    }
    await close();
  });

  test('screenshots: the pictures of the documents show the pages as they are', async () => {
    await campus();
    const pictures = await picturesOf(system);
    const named = [...new Set(['README.md', 'docs/web.md'].flatMap(shownBy))].sort();
    assert.deepEqual(named, Object.keys(pictures).sort(), 'each picture is shown by README.md or docs/web.md');
    const stored = storedStructures();
    const { page, close } = await open(browser(), system.url, viewport);
    for (const [name, wanted] of Object.entries(pictures)) {
      const file = join(root, folder, `${name}.png`);
      assert.ok(existsSync(file) && statSync(file).size <= LARGEST, `${file} exists and has at most ${LARGEST} bytes`);
      await show(page, wanted);
      assert.deepEqual(await structureOf(page), stored[name], `${name}.png shows another page than there is now: run \`make screenshots\`, look at it, and commit it`);
    }
    await close();
  });
}

// SPDX-License-Identifier: Apache-2.0
// Pages that have nothing to show, or nothing new.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, launch, open, picture } from '../browser.mjs';
import { until } from '../system.mjs';

export function addStates({ system, browser, at, campus }) {
  test('stale: without the server the page says so, keeps what it shows, and recovers', async (t) => {
    t.after(async () => {
      if (!system.serverRuns()) system.startServer(); // the other tests need it
      await system.ready();
    });
    await campus();
    const { page, close } = await open(browser(), at('demo/campus'), { expected: /Failed to load resource|EventSource/ });
    await until('the maps are drawn', async () => (await drawnMaps(page)).length > 0);
    const maps = (await drawnMaps(page)).length;
    await system.kill('server');
    await page.getByText(/Not live since/).waitFor();
    await picture(page, 'stale');
    assert.equal((await drawnMaps(page)).length, maps, 'the maps stay');
    const other = await open(browser(), at('demo/campus'), { expected: /Failed to load resource|EventSource/ });
    await other.page.getByText(/cannot be loaded/).first().waitFor();
    await picture(other.page, 'server-away');
    await other.close();
    system.startServer();
    await system.ready();
    await page.getByText(/Not live since/).waitFor({ state: 'detached', timeout: 60_000 });
    await close();
  });

  test('empty_states: each says what to do', async () => {
    for (const [path, words, name] of [['empty/campus', /enfilade .*robot/, 'empty-campus'], ['empty/maps', /No maps yet/, 'empty-maps'],
      ['empty/nonsense', /There is no such page/, 'no-such-page']]) {
      const { page, close } = await open(browser(), at(path));
      await page.locator('main').getByText(words).first().waitFor();
      await picture(page, name);
      await close();
    }
  });

  test('no_webgl: a browser that cannot draw the maps shows the server\'s picture of them', async () => {
    await campus();
    const without = await launch(['--disable-3d-apis']);
    try {
      const { page, close } = await open(without, at('demo/campus'));
      const composite = page.getByRole('img', { name: /All maps of the level/ });
      await until('the picture is there', () => composite.evaluate((image) => image.complete && image.naturalWidth === 1024));
      await page.getByText(/needs WebGL2/).waitFor();
      await picture(page, 'no-webgl');
      assert.deepEqual(await faultsOf(page), []);
      await close();
    } finally {
      await without.close();
    }
  });
}

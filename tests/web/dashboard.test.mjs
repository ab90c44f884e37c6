// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { faultsOf, launch, open, picture } from './browser.mjs';
import { System, until } from './system.mjs';

const system = new System();
let browser;

before(async () => {
  await system.start();
  browser = await launch();
  system.enfilade('demo', 'site', 'create', 'demo', '--name', 'Simulated campus');
  system.enfilade('empty', 'site', 'create', 'empty', '--name', 'Empty site');
  await system.drive('demo', 'r1', '--campus', 'figure1', '--rate', '20', '--map', 'Hall');
});

after(async () => {
  await browser?.close();
  await system.stop();
});

const drawnMaps = (page) => page.evaluate(() => (window.__scene?.drawn() ?? []).filter(({ kind }) => kind === 'map'));
const at = (path) => `${system.url}/s/${path}`;

test('campus_figure1: all maps are drawn, and link points where the graph places them', async () => {
  const { graph } = await system.call('sites/demo/graph');
  const placed = graph.maps.filter(({ poseWorldMap }) => poseWorldMap);
  assert.ok(placed.length >= 4, `${placed.length} maps are placed`);
  const { page, close } = await open(browser, at('demo/campus'));
  await until('all maps are drawn', async () => (await drawnMaps(page)).length >= placed.length);
  await page.waitForLoadState('networkidle').catch(() => {}); // the stream stays open
  for (const name of ['light', 'dark']) {
    await page.emulateMedia({ colorScheme: name });
    await picture(page, `campus-${name}`);
  }
  const names = new Set((await drawnMaps(page)).map(({ name }) => name));
  for (const { map } of placed) assert.ok(names.has(map), `${map} is drawn`);
  const away = await page.evaluate((points) => {
    const drawn = new Map(window.__scene.drawn().map((object) => [object.name, object]));
    return points.map(({ linkPoint, poseWorldPlace: { pose } }) => {
      const [at, wanted] = [drawn.get(linkPoint), window.__scene.project(pose)];
      return at ? Math.hypot(at.x - wanted.x, at.y - wanted.y) : Infinity;
    });
  }, graph.linkPoints.filter(({ poseWorldPlace }) => poseWorldPlace));
  assert.ok(away.length >= 5 && Math.max(...away) < 1, `pixels between link points and their places: ${away}`);
  await page.getByRole('listbox', { name: 'Objects in view' }).focus();
  await page.keyboard.press('Enter');
  await until('the selection is in the address', () => page.url().includes('sel='));
  await close();
});

test('stale: without the server the page says so, keeps what it shows, and recovers', async (t) => {
  t.after(async () => {
    if (!system.serverRuns()) system.startServer(); // the other tests need it
    await system.ready();
  });
  const { page, close } = await open(browser, at('demo/campus'), { expected: /Failed to load resource|EventSource/ });
  await until('the maps are drawn', async () => (await drawnMaps(page)).length > 0);
  const maps = (await drawnMaps(page)).length;
  await system.kill('server');
  await page.getByText(/Not live since/).waitFor();
  await picture(page, 'stale');
  assert.equal((await drawnMaps(page)).length, maps, 'the maps stay');
  const other = await open(browser, at('demo/campus'), { expected: /Failed to load resource|EventSource/ });
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
    const { page, close } = await open(browser, at(path));
    await page.locator('main').getByText(words).first().waitFor();
    await picture(page, name);
    await close();
  }
});

test('no_webgl: a browser that cannot draw the maps shows the server\'s picture of them', async () => {
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

test('security: names of HTML and of scripts are text', async () => {
  system.enfilade('odd', 'site', 'create', 'odd', '--name', '<img src=x onerror=alert(1)>');
  const names = ['<script>window.executed = 1</script>', '<img src=x onerror="window.executed = 1">', 'javascript:window.executed=1'];
  for (const displayName of names) await system.call('sites/odd/maps', { displayName });
  for (const path of ['odd/maps', 'odd/campus']) {
    const { page, close } = await open(browser, at(path));
    if (path === 'odd/maps') for (const name of names) await page.getByText(name, { exact: true }).first().waitFor();
    else await page.locator('main').getByText(/./).first().waitFor();
    assert.equal(await page.evaluate(() => window.executed), undefined);
    for (const href of await page.locator('a').evaluateAll((links) => links.map((link) => link.href))) assert.match(href, /^http:/);
    await close();
  }
});

test('a11y: axe finds nothing serious on any page in either theme', async () => {
  const first = await open(browser, at('demo/campus'));
  const links = first.page.getByRole('navigation', { name: 'Pages' }).locator('a.rail-link');
  await links.first().waitFor();
  const paths = await links.evaluateAll((all) => all.map((link) => new URL(link.href).pathname));
  await first.close();
  for (const theme of ['light', 'dark']) {
    for (const path of [...paths, '/s/demo/history/audit', '/', '/s/empty/campus', '/s/empty/maps']) {
      const { page, close } = await open(browser, system.url + path, { theme });
      await page.locator('main').getByText(/./).first().waitFor();
      await until('nothing is being loaded', async () => (await page.getByRole('status', { name: 'Loading' }).count()) === 0);
      await picture(page, `page${path.replaceAll('/', '-')}-${theme}`);
      assert.deepEqual(await faultsOf(page), [], `${path}, ${theme}`);
      await close();
    }
  }
});

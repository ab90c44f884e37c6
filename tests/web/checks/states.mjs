// SPDX-License-Identifier: Apache-2.0
// Pages that have nothing to show, or nothing new.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, launch, open, picture, settled } from '../browser.mjs';
import { importMap, pgmOf } from '../maps.mjs';
import { Robots } from '../robots.mjs';
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

  test('stale: a robot that reports no longer is shown as old after 10 s, and stays', async (t) => {
    system.enfilade('old', 'site', 'create', 'old');
    await importMap(system, 'old', 'm', pgmOf(200, 200, (x, y) => x === 0 || y === 0));
    const robots = new Robots(system, 'old');
    t.after(() => robots.close());
    const name = await robots.begin('r', 'm');
    const report = () => robots.report('r', 'm', { x: 5, y: 5, yaw: 0 });
    report();
    const timer = setInterval(report, 1000);
    t.after(() => clearInterval(timer));
    const { page, close } = await open(browser(), at('old/campus'), { expected: /Failed to load resource|EventSource/ });
    const robot = page.getByRole('option', { name: /^r\b/ });
    await robot.getByText('now').waitFor();
    clearInterval(timer);
    await robot.getByText(/1\d s ago/).waitFor();
    await picture(page, 'stale-robot');
    const isDrawn = () => page.evaluate((wanted) => window.__scene.drawn().some((item) => item.name === wanted), name);
    assert.ok(await isDrawn(), 'an old robot is drawn');
    t.after(async () => {
      if (!system.serverRuns()) system.startServer();
      await system.ready();
    });
    await system.kill('server');
    await page.getByText(/Not live since/).waitFor();
    system.startServer();
    await system.ready();
    await page.getByText(/Not live since/).waitFor({ state: 'detached', timeout: 60_000 });
    await robot.getByText(/ago/).waitFor();
    assert.ok(await isDrawn(), 'it stays when the stream has come back');
    await close();
  });

  // A browser opens six connections to a host over HTTP/1.1, and each stream takes one.
  test('hidden_tab: a tab that nobody sees gives its connection back, and is up to date when it is seen again', async () => {
    system.enfilade('hidden', 'site', 'create', 'hidden');
    await system.call('sites/hidden/maps?mapId=one', { displayName: 'one' });
    const { page, close } = await open(browser(), at('hidden/maps'));
    await page.getByRole('link', { name: 'one' }).waitFor();
    const openRequests = async () => (await (await fetch(`${system.url}/statusz`)).json()).openRequests - 1; // itself
    const turn = (hidden) => page.evaluate((value) => {
      Object.defineProperty(document, 'hidden', { configurable: true, get: () => value });
      document.dispatchEvent(new Event('visibilitychange'));
    }, hidden);
    await until('the stream is open', async () => (await openRequests()) === 1);
    await turn(true);
    await until('the stream is closed', async () => (await openRequests()) === 0);
    await system.call('sites/hidden/maps?mapId=two', { displayName: 'two' });
    assert.equal(await page.getByRole('link', { name: 'two' }).count(), 0);
    await turn(false);
    await page.getByRole('link', { name: 'two' }).waitFor();
    await page.getByText('Live', { exact: true }).waitFor();
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

  test('empty_states: maps and robots that cannot be shown are listed, with what to do', async (t) => {
    system.enfilade('bare', 'site', 'create', 'bare');
    for (const [id, name] of [['root', 'Root without content'], ['lone', 'Not joined']]) await system.call(`sites/bare/maps?mapId=${id}`, { displayName: name });
    await importMap(system, 'bare', 'away', pgmOf(100, 100, (x) => x === 0), 'Mapped, not joined');
    await system.call('sites/bare/robots?robotId=silent', { displayName: 'Silent' });
    const robots = new Robots(system, 'bare');
    t.after(() => robots.close());
    await robots.begin('lost', 'away');
    robots.report('lost', 'away', { x: 1, y: 1, yaw: 0 });
    const { page, close } = await open(browser(), at('bare/campus'));
    const tray = page.locator('.unplaced');
    await tray.getByText('Not placed (4)').waitFor();
    await tray.locator('summary').click();
    for (const words of [/Root without content.*Nothing is mapped in it yet. Drive a robot/, /Mapped, not joined.*Drive a robot through one of its doors/, /lost.*not joined to the root/]) {
      await tray.getByRole('listitem').filter({ hasText: words }).waitFor();
    }
    await picture(page, 'nothing-placed');
    assert.deepEqual(await faultsOf(page), []);
    await page.goto(at('bare/robots'));
    await page.getByRole('row', { name: /Silent/ }).getByText('No pose yet').waitFor();
    await close();
  });

  test('empty_states: a map whose graphics are lost says so, and is drawn again', async () => {
    system.enfilade('graphics', 'site', 'create', 'graphics');
    await importMap(system, 'graphics', 'm', pgmOf(400, 400, (x, y) => x === 0 || y === 0 || x === y));
    const { page, close } = await open(browser(), at('graphics/campus'), { expected: /WebGL/ });
    await until('the map is drawn', async () => (await drawnMaps(page)).length === 1);
    await settled(page);
    const shot = () => page.locator('.scene-canvas').screenshot();
    const before = await shot();
    const context = await page.evaluateHandle(() => document.querySelector('.scene-canvas').getContext('webgl2').getExtension('WEBGL_lose_context'));
    await context.evaluate((extension) => extension.loseContext());
    await page.getByText(/graphics card has dropped the map/).waitFor();
    await page.getByRole('button', { name: 'Load again' }).waitFor();
    await picture(page, 'context-lost');
    assert.deepEqual(await faultsOf(page), []);
    await context.evaluate((extension) => extension.restoreContext());
    await page.getByText(/graphics card has dropped the map/).waitFor({ state: 'detached' });
    await until('the same picture is back', async () => before.equals(await shot()));
    await close();
  });

  test('empty_states: a browser that cannot draw the maps shows the server\'s picture of them', async () => {
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

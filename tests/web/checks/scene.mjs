// SPDX-License-Identifier: Apache-2.0
// What the map shows, against what the API says.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, open, picture, settled } from '../browser.mjs';
import { until } from '../system.mjs';

export function addScene({ system, browser, at, campus }) {
  test('campus_figure1: all maps are drawn, and link points where the graph places them', async () => {
    await campus();
    const { graph } = await system.call('sites/demo/graph');
    const placed = graph.maps.filter(({ poseWorldMap }) => poseWorldMap);
    assert.ok(placed.length >= 4, `${placed.length} maps are placed`);
    const { page, close } = await open(browser(), at('demo/campus'));
    await until('all maps are drawn', async () => (await drawnMaps(page)).length >= placed.length);
    await settled(page);
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
}

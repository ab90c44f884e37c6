// SPDX-License-Identifier: Apache-2.0
// A robot's own page.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultsOf, open, picture, settled } from '../browser.mjs';
import { twoRooms } from '../maps.mjs';
import { Robots } from '../robots.mjs';
import { sceneOf } from '../pixels.mjs';
import { until } from '../system.mjs';

export function addRobots({ system, browser, at }) {
  test('robot: its page shows where it is, how that is known, and its sessions', async (t) => {
    const site = 'robots';
    await twoRooms(system, site);
    const robots = new Robots(system, site);
    t.after(() => robots.close());
    const name = await robots.begin('r', 'b');
    robots.report('r', 'b', { x: 2, y: 2 });
    const { page, close } = await open(browser(), at(`${site}/robots`));
    await page.getByRole('cell', { name: 'Reports its pose' }).waitFor();
    await page.getByRole('link', { name: 'r', exact: true }).click();
    await page.getByRole('heading', { name: 'Robots / r' }).waitFor();
    await page.getByText('Share of the position uncertainty').waitFor();
    const inTheMiddle = async () => {
      const { drawn, size } = await sceneOf(page);
      const icon = drawn.find((item) => item.name === name);
      return icon !== undefined && Math.hypot(icon.x - size.width / 2, icon.y - size.height / 2) < 2;
    };
    await until('the robot is in the middle', inTheMiddle);
    robots.report('r', 'b', { x: 6, y: 4, yaw: 1 });
    await page.getByText('6.00, 4.00 m').waitFor();
    await until('it stays there when it moves', inTheMiddle);
    assert.equal(await page.getByRole('region', { name: 'Sessions over time' }).getByRole('link').count(), 1);
    await settled(page);
    await picture(page, 'robot');
    assert.deepEqual(await faultsOf(page), []);

    // In another map that is not joined it is shown in that map.
    await system.call(`sites/${site}/maps?mapId=apart`, { displayName: 'apart' });
    robots.report('r', 'apart', { x: 1, y: 1 });
    await page.getByText('No link points join').waitFor();
    await until('the robot is drawn in its map', async () => (await sceneOf(page)).drawn.some((item) => item.name === name));

    await close();

    const nobody = await open(browser(), at(`${site}/robots/nobody`), { expected: /Failed to load resource/ });
    await nobody.page.getByRole('alert').getByText(/robots\/nobody/).waitFor();
    await nobody.close();
  });
}

// SPDX-License-Identifier: Apache-2.0
// What people do on the campus, besides looking at it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, picture, settled } from '../browser.mjs';
import { moveDoor, twoRooms } from '../maps.mjs';
import { distance, pixelsOf, placed, sceneOf, seenFrom, toScreen } from '../pixels.mjs';
import { Robots } from '../robots.mjs';
import { until } from '../system.mjs';

const poseOf = async (system, site, map) => {
  const { graph } = await system.call(`sites/${site}/graph`);
  return graph.maps.find((one) => one.map === `sites/${site}/maps/${map}`).poseWorldMap.pose;
};

const trailOf = async (page, robot) => (await sceneOf(page)).marks.find(({ kind, name }) => kind === 'trail' && name === robot);

export function addCampus({ system, browser, at }) {
  test('trail: a robot draws its way behind it, which moves with the map, and can be hidden', async (t) => {
    const site = 'trails';
    await twoRooms(system, site);
    const robots = new Robots(system, site);
    t.after(() => robots.close());
    const robot = await robots.begin('r', 'b');
    const from = { x: 2, y: 2 };
    robots.report('r', 'b', from);
    const { page, close } = await open(browser(), `${at(`${site}/campus`)}?sel=robots/r`);
    await until('robot and maps are drawn', async () => (await sceneOf(page)).drawn.length === 4); // two maps, the door, the robot
    for (let x = from.x; x <= 7; x += 0.5) {
      robots.report('r', 'b', { x, y: 2 });
      const pose = placed(await poseOf(system, site, 'b'), { x, y: 2 });
      await until('the report is drawn', async () => {
        const { camera, size, drawn } = await sceneOf(page);
        return distance(drawn.find(({ name }) => name === robot), toScreen(camera, size, pose)) < 1;
      });
    }
    const startAt = async (pose) => {
      const { camera, size } = await sceneOf(page);
      return toScreen(camera, size, placed(pose, from));
    };
    const before = await poseOf(system, site, 'b');
    await until('the trail goes back to where the robot came from', async () => distance((await trailOf(page, robot))?.to ?? { x: 1e9, y: 0 }, await startAt(before)) < 1);
    await picture(page, 'trail');
    const middle = placed(before, { x: 4, y: 2 });
    const isDrawn = async () => {
      const { camera, size } = await sceneOf(page);
      const { x, y } = toScreen(camera, size, middle);
      const [red, , blue] = (await pixelsOf(page)).at(Math.floor(x), Math.floor(y));
      return blue - red > 40;
    };
    assert.ok(await isDrawn(), 'there is a blue line on the way');
    const button = page.locator('button[aria-label="Show where robots come from"]');
    assert.equal(await button.getAttribute('aria-pressed'), 'true');
    await page.locator('.scene-canvas').press('t');
    await settled(page);
    assert.equal(await isDrawn(), false);
    assert.equal(await button.getAttribute('aria-pressed'), 'false');
    await page.locator('.scene-canvas').press('t');

    await moveDoor(system, site, { x: 10, y: 8, yaw: 0.3 });
    const after = await poseOf(system, site, 'b');
    assert.ok(distance(after, before) > 1);
    await until('the trail has moved with the map', async () => distance((await trailOf(page, robot))?.to ?? { x: 1e9, y: 0 }, await startAt(after)) < 1);
    await close();
  });

  test('coordinates: of a place are copied in each frame, by the pointer and by the keyboard', async () => {
    const site = 'points';
    await twoRooms(system, site);
    const { page, close } = await open(browser(), at(`${site}/campus`));
    await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    const copied = async () => (await page.evaluate(() => navigator.clipboard.readText())).split(/[ ,]+/).map(Number);
    await until('both maps are drawn', async () => (await drawnMaps(page)).length === 2);
    await settled(page);
    const pose = await poseOf(system, site, 'b');
    const inB = { x: 6, y: 3 };
    const { camera, size } = await sceneOf(page);
    const wanted = placed(pose, inB);
    const screen = toScreen(camera, size, wanted);
    const canvas = page.locator('.scene-canvas');
    const menu = page.getByRole('menu', { name: 'Copy the coordinates of this place' });
    const pixel = 1 / camera.scale; // clicks are at whole pixels
    await canvas.click({ button: 'right', position: { x: Math.round(screen.x), y: Math.round(screen.y) } });
    await picture(page, 'point-menu');
    assert.deepEqual(await faultsOf(page), []);
    await menu.getByRole('menuitem', { name: 'in b' }).click();
    await page.getByText(/^Copied /).waitFor();
    const [x, y] = await copied();
    assert.ok(distance({ x, y }, inB) < pixel, `${x}, ${y} in the map`);
    assert.equal(await menu.count(), 0);

    // By the keyboard it is the place under the pointer, or the middle of the view.
    await page.mouse.move(0, 0);
    await canvas.focus();
    await page.keyboard.press('c');
    await until('the first entry has the focus', () => menu.getByRole('menuitem', { name: 'in the world' }).evaluate((item) => item === document.activeElement));
    await page.keyboard.press('Enter');
    await until('the middle is copied', async () => distance({ x: (await copied())[0], y: (await copied())[1] }, camera) < 0.001);
    assert.ok(await canvas.evaluate((element) => element === document.activeElement), 'the focus is back on the map');
    await page.keyboard.press('c');
    await menu.waitFor();
    await page.keyboard.press('Escape');
    await menu.waitFor({ state: 'detached' });

    // On the page of a map, in its own frame.
    await page.goto(at(`${site}/maps/b`));
    await until('the map is drawn', async () => (await drawnMaps(page)).length === 1);
    await settled(page);
    const own = await sceneOf(page);
    const place = toScreen(own.camera, own.size, inB);
    await canvas.click({ button: 'right', position: { x: Math.round(place.x), y: Math.round(place.y) } });
    await menu.getByRole('menuitem', { name: 'in the world' }).click();
    await page.getByText(/^Copied /).waitFor();
    const [wx, wy] = await copied();
    assert.ok(distance(seenFrom(pose, { x: wx, y: wy }), inB) < 1 / own.camera.scale, `${wx}, ${wy} in the world`);
    await close();
  });
}

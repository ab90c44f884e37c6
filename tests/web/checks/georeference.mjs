// SPDX-License-Identifier: Apache-2.0
// A site gets its place on the globe in the browser, against what GetGeoreference and the server's GeoJSON say.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, picture, settled } from '../browser.mjs';
import { twoRooms } from '../maps.mjs';
import { distance, sceneOf, toScreen } from '../pixels.mjs';
import { until } from '../system.mjs';

const SITE = 'globe';

// About 10 m apart on the ground at this latitude: north is up in map a.
const known = [{ x: 0, y: 0, latitude: 50.7744, longitude: 6.0786 }, { x: 8, y: 6, latitude: 50.77445393, longitude: 6.07871346 }];

const georeferenceOf = async (system) => {
  const answer = await fetch(`${system.url}/v1/sites/${SITE}/georeference`);
  return answer.ok ? (await answer.json()).georeference : undefined;
};

async function enter(page, { latitude, longitude }) {
  await page.getByLabel('Latitude, °').fill(String(latitude));
  await page.getByLabel('Longitude, °').fill(String(longitude));
  await page.getByRole('button', { name: 'Add the point' }).click();
}

export function addGeoreference({ system, browser, at }) {
  test('georeference: control points by a click and by the keyboard place a site on the globe', async () => {
    await twoRooms(system, SITE);
    const { page, close } = await open(browser(), at(`${SITE}/georeference`), { expected: /Failed to load resource/ });
    await until('both maps are drawn', async () => (await drawnMaps(page)).length === 2);
    await settled(page);
    await page.getByText('no place on the globe yet').waitFor();

    // The first by a click at the place in map a, the second by numbers and keys alone.
    const { camera, size } = await sceneOf(page);
    const screen = toScreen(camera, size, { x: 3, y: 4 });
    await page.locator('.scene-canvas').click({ position: { x: Math.round(screen.x), y: Math.round(screen.y) } });
    const chosen = async () => Promise.all(['x', 'y'].map(async (axis) => Number((await page.getByLabel(`${axis} in the map, m`).inputValue()) || NaN)));
    await until('the form has the place', async () => {
      const [x, y] = await chosen();
      return Math.abs(x - 3) * camera.scale < 1.2 && Math.abs(y - 4) * camera.scale < 1.2;
    }).catch(async () => assert.fail(`the click was at ${await chosen()}`));
    const pinAt = async (name) => (await sceneOf(page)).marks.find((mark) => mark.kind === 'pin' && mark.name === name)?.from;
    await until('the place is marked', async () => distance((await pinAt('chosen')) ?? { x: 1e9, y: 0 }, screen) < 1);
    await page.getByLabel('x in the map, m').fill(String(known[0].x));
    await page.getByLabel('y in the map, m').fill(String(known[0].y));
    await enter(page, known[0]);
    await page.getByText('One point does not tell the direction').waitFor();
    assert.ok(await page.getByRole('button', { name: 'Save', exact: true }).isDisabled());

    // What the server refuses is told as it says it.
    await page.getByLabel('x in the map, m').fill('8');
    await page.getByLabel('y in the map, m').fill('6');
    await enter(page, { latitude: 50.7844, longitude: 6.0786 });
    await page.getByRole('button', { name: 'Save', exact: true }).click();
    await page.getByRole('alert').getByText(/The request is not valid: the control points are .* times as far apart/).waitFor();
    assert.equal(await georeferenceOf(system), undefined);
    await page.getByRole('button', { name: 'Undo' }).click();
    await until('one is left', async () => (await page.getByRole('list', { name: 'Control points' }).getByRole('listitem').count()) === 1);

    const form = page.getByRole('form', { name: 'New control point' });
    await form.getByLabel('x in the map, m').focus();
    for (const text of ['8', '6', `${known[1].latitude}, ${known[1].longitude}`]) {
      await page.keyboard.type(text);
      await page.keyboard.press('Tab');
    }
    await page.keyboard.press('Enter'); // in the field of the longitude
    const list = page.getByRole('list', { name: 'Control points' }).getByRole('listitem');
    await until('there are two points', async () => (await list.count()) === 2);
    await page.getByRole('button', { name: 'Save', exact: true }).focus();
    await page.keyboard.press('Enter');
    const saved = await until('the server has them', () => georeferenceOf(system));
    for (const [i, { residualM = 0 }] of saved.controlPoints.entries()) await list.nth(i).getByText(`residual ${residualM.toFixed(2)} m`).waitFor();
    await page.getByText(`${((saved.yawEastWorld ?? 0) * 180 / Math.PI).toFixed(1).replace('-0.0', '0.0')}° from east`).waitFor();
    await page.getByRole('img', { name: 'The site on the globe: 50.8° north, 6.1° east' }).waitFor();
    for (const [i, point] of known.entries()) await until('the point is marked where it is', async () => distance((await pinAt(`control ${i + 1}`)) ?? { x: 1e9, y: 0 }, toScreen(camera, size, point)) < 1);
    await picture(page, 'georeference');
    assert.deepEqual(await faultsOf(page), []);

    // The page's latitude and longitude of a place are those of the server, to a centimetre (1e-7 degrees).
    const { features } = await (await fetch(`${system.url}/v1/sites/${SITE}/graph.geojson`)).json();
    const door = features.find(({ id }) => id === 'linkPoints/door');
    await page.goto(`${at(`${SITE}/campus`)}?sel=linkPoints/door`);
    const shown = page.locator('dt', { hasText: 'On the globe' }).locator('+ dd');
    await shown.waitFor();
    const [latitude, longitude] = (await shown.textContent()).split(',').map(Number.parseFloat);
    const [lon, lat] = door.geometry.coordinates;
    assert.ok(Math.abs(latitude - lat) < 2e-7 && Math.abs(longitude - lon) < 3e-7, `${latitude}, ${longitude} is ${lat}, ${lon}`);

    // Removing all points removes it.
    await page.goto(at(`${SITE}/georeference`));
    for (const _ of known) await page.getByRole('button', { name: 'Remove control point 1' }).click();
    await page.getByRole('button', { name: 'Remove the georeference' }).click();
    await page.getByText('no place on the globe yet').waitFor();
    assert.equal(await georeferenceOf(system), undefined);
    await close();

    // It is known from the history then: asking for it would be an error on the console.
    const after = await open(browser(), `${at(`${SITE}/campus`)}?sel=linkPoints/door`);
    await after.page.getByText('In the world').waitFor();
    await settled(after.page);
    await after.close();
  });

  test('georeference: fits a phone, in both themes, and says what it needs', async () => {
    for (const theme of ['light', 'dark']) {
      const { page, close } = await open(browser(), at('empty/georeference'), { theme, width: 390, height: 780 });
      await page.getByText('There is nothing to place on the globe yet').waitFor();
      assert.ok(await page.evaluate(() => document.querySelector('main').scrollWidth <= innerWidth), 'nothing sticks out');
      assert.deepEqual(await faultsOf(page), [], theme);
      await close();
    }
  });
}

// SPDX-License-Identifier: Apache-2.0
// The maps where they were, against what ListPlacedMaps says.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, picture, settled } from '../browser.mjs';
import { anchor, importMap, pgmOf } from '../maps.mjs';
import { distance, placed, sceneOf, toScreen } from '../pixels.mjs';
import { until } from '../system.mjs';

// Two rooms of 10 m x 10 m, and a door between them that is moved twice: each time the maps are placed anew.
async function movedRooms(system) {
  const room = pgmOf(200, 200, (x, y) => x === 0 || y === 0 || x === 199 || y === 199);
  system.enfilade('past', 'site', 'create', 'past');
  for (const map of ['a', 'b']) await importMap(system, 'past', map, room);
  const door = 'sites/past/linkPoints/door';
  const anchors = (yaw, y) => [anchor('past', 'a', { x: 10, y, yaw: 0 }), anchor('past', 'b', { x: 0, y: 5, yaw })];
  await system.call('sites/past/linkPoints?linkPointId=door', { kind: 'KIND_DOOR', anchors: anchors(-0.5, 5) });
  await system.call('sites/past:optimize', {});
  for (const [yaw, y] of [[-0.6, 5.5], [-0.9, 8]]) {
    const { linkPoint } = await system.call(door);
    const answer = await fetch(`${system.url}/v1/${door}?updateMask=anchors`, {
      method: 'PATCH', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ ...linkPoint, anchors: anchors(yaw, y) }),
    });
    assert.equal(answer.status, 200, await answer.text());
    await system.call('sites/past:optimize', {});
  }
}

// The optimisations, the oldest first, each with the pose of every map.
async function placingsOf(system) {
  const { graphVersions } = await system.call('sites/past/graphVersions');
  const versions = graphVersions.filter(({ cause }) => cause === 'CAUSE_OPTIMIZED').map(({ graphVersion }) => graphVersion).reverse();
  return Promise.all(versions.map(async (version) => {
    const { placedMaps } = await system.call(`sites/past/graphVersions/${version}/placedMaps`);
    return { version, poses: new Map(placedMaps.map(({ map, poseWorldMap }) => [map.split('/').pop(), poseWorldMap.pose])) };
  }));
}

const middle = (pose) => placed(pose, { x: 5, y: 5 });

// How far the maps are drawn from where the RPC's poses have them, in pixels.
const awayFrom = ({ drawn, camera, size }, poses) =>
  Math.max(...[...poses].map(([map, pose]) => {
    const found = drawn.find(({ name }) => name === `sites/past/maps/${map}`);
    return found ? distance(found, toScreen(camera, size, middle(pose))) : Infinity;
  }));

export function addHistory({ system, browser, at }) {
  test('history: a slider moves the maps to where each optimisation placed them, and arrows show the difference', async () => {
    await movedRooms(system);
    const placings = await placingsOf(system);
    assert.ok(placings.length >= 3, `${placings.length} optimisations`);
    const moves = distance(middle(placings.at(0).poses.get('b')), middle(placings.at(-1).poses.get('b')));
    assert.ok(moves > 2, `the door has moved map b by ${moves} m`);
    const { page, close } = await open(browser(), at('past/history'));
    await until('both maps are drawn', async () => (await drawnMaps(page)).length === 2);
    await settled(page);
    const slider = page.getByRole('slider', { name: 'Version of the graph' });
    assert.equal(await slider.getAttribute('max'), String(placings.length - 1));
    assert.equal(await slider.inputValue(), String(placings.length - 1), 'the newest is shown first');
    const requests = [];
    page.on('request', (request) => requests.push(new URL(request.url()).pathname));
    await slider.focus();
    await page.keyboard.press('Home');
    for (const [i, { version, poses }] of placings.entries()) {
      if (i > 0) await page.keyboard.press('ArrowRight');
      await until(`version ${version} is shown`, async () => new URL(page.url()).searchParams.get('at') === version && awayFrom(await sceneOf(page), poses) < 1);
      await page.getByRole('heading', { name: `Version ${version}`, exact: true }).waitFor();
    }
    assert.deepEqual(requests.filter((path) => /tiles|overview|manifest/.test(path)), [], 'no raster is fetched again');
    assert.deepEqual((await sceneOf(page)).drawn.filter(({ kind }) => kind !== 'map'), [], 'link points and robots, whose places are those of now, are left out');

    // The first and the last, to scale.
    const [from, to] = [placings.at(0), placings.at(-1)];
    await page.getByLabel('Since version').selectOption(from.version);
    await page.getByLabel('Arrows').selectOption('1');
    assert.equal(new URL(page.url()).searchParams.get('from'), from.version);
    const wanted = { from: middle(from.poses.get('b')), to: middle(to.poses.get('b')) };
    const isRight = ({ marks, camera, size }) => {
      const mark = marks.find(({ name }) => name === 'sites/past/maps/b');
      return mark && distance(mark.from, toScreen(camera, size, wanted.from)) < 1 && distance(mark.to, toScreen(camera, size, wanted.to)) < 1;
    };
    await until('the arrow is drawn between the two places', async () => isRight(await sceneOf(page)));
    const row = page.getByRole('row').filter({ has: page.getByRole('button', { name: 'b', exact: true }) });
    const [, moved, turned] = await row.getByRole('cell').allTextContents();
    assert.equal(moved, `${distance(wanted.from, wanted.to).toFixed(2)} m`);
    const turn = ((to.poses.get('b').yaw - from.poses.get('b').yaw) * 180) / Math.PI;
    assert.ok(Math.abs(Number.parseFloat(turned.replace('−', '-')) - turn) < 0.011, `${turned} is ${turn}`);
    await page.getByText('1 map has not moved.').waitFor();
    await page.getByLabel('Arrows').selectOption('10');
    await until('the arrow is ten times as long', async () => {
      const { marks, camera } = await sceneOf(page);
      const mark = marks.find(({ name }) => name === 'sites/past/maps/b');
      return mark && Math.abs(distance(mark.from, mark.to) - 10 * distance(wanted.from, wanted.to) * camera.scale) < 1;
    });
    await page.getByLabel('Arrows').selectOption('1');
    await page.getByLabel('Show all').click();
    await settled(page);
    await picture(page, 'history-moves');
    await close();
  });

  test('history: plays from the oldest version to the newest, by the keyboard, and the address brings a version back', async () => {
    const placings = await placingsOf(system);
    const { page, close } = await open(browser(), at(`past/history?at=${placings.at(-1).version}`));
    await until('the maps are drawn', async () => (await drawnMaps(page)).length === 2);
    const played = [];
    page.on('framenavigated', (frame) => played.push(new URL(frame.url()).searchParams.get('at')));
    await page.getByRole('button', { name: 'Play' }).focus();
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    await page.getByRole('button', { name: 'Play' }).waitFor(); // it has ended
    assert.deepEqual(played, placings.map(({ version }) => version));
    await page.goto(at(`past/history?at=${placings[0].version}&from=${placings.at(-1).version}`));
    await until('the version of the address is drawn', async () => awayFrom(await sceneOf(page), placings[0].poses) < 1);
    assert.equal(await page.getByLabel('Since version').inputValue(), placings.at(-1).version);
    await page.goto(at('past/history?at=999999'));
    await page.getByText(/Version 999999 is no optimisation/).waitFor();
    await page.goto(at('past/history/versions'));
    await page.getByRole('link', { name: placings[0].version, exact: true }).click();
    await until('the table of versions leads there', () => page.url().includes(`history?at=${placings[0].version}`));
    await close();
  });

  test('history: on a phone, and of a site whose maps have no place yet', async () => {
    for (const theme of ['light', 'dark']) {
      const { page, close } = await open(browser(), at('past/history'), { theme, width: 390, height: 780 });
      await until('the maps are drawn', async () => (await drawnMaps(page)).length === 2);
      await settled(page);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'nothing sticks out');
      await page.getByRole('slider', { name: 'Version of the graph' }).waitFor();
      await picture(page, `history-phone-${theme}`);
      assert.deepEqual(await faultsOf(page), [], theme);
      await close();
    }
    const { page, close } = await open(browser(), at('empty/history'));
    await page.getByText(/have not been placed yet/).waitFor();
    assert.deepEqual(await faultsOf(page), []);
    await close();
  });
}

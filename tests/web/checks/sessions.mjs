// SPDX-License-Identifier: Apache-2.0
// What a session's page shows of its drive and of its doors, against ExportTrajectory, ListDoorVerdicts and GetDoorImages.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultsOf, open, picture, settled } from '../browser.mjs';
import { distance, sceneOf, toScreen } from '../pixels.mjs';
import { until } from '../system.mjs';

const idOf = (name) => name.split('/').pop();

// By the API: [{time, pose}] with the time in seconds since the first.
async function trajectoryOf(system, session) {
  const text = await (await fetch(`${system.url}/v1/${session}/trajectory:export`)).text();
  const poses = text.split('\n').filter(Boolean).flatMap((line) => JSON.parse(line).result.poses ?? []);
  const [begin] = poses.map(({ time }) => Date.parse(time));
  return poses.map(({ time, poseMapRobot: { x = 0, y = 0, yaw = 0 } = {} }) => ({ time: (Date.parse(time) - begin) / 1000, pose: { x, y, yaw } }));
}

// How far the drawn robot is from where `pose` belongs: place, and a point a metre ahead of it.
async function awayFrom(page, { x, y, yaw }) {
  const { size, camera, marks } = await sceneOf(page);
  const cursor = marks.find(({ kind }) => kind === 'cursor');
  if (!cursor) return Infinity;
  const ahead = { x: x + Math.cos(yaw), y: y + Math.sin(yaw) };
  return Math.max(distance(cursor.from, toScreen(camera, size, { x, y })), distance(cursor.to, toScreen(camera, size, ahead)));
}

const hexOf = ({ content: { sha256 } }) => Buffer.from(sha256, 'base64').toString('hex');

// The passage that was compared with the most places, of those with more images than fit beside each other and with images
// of the best place. Which passages have them depends on how fast the drives were mapped.
async function comparedVerdict(system) {
  const { sessions } = await system.call('sites/demo/sessions?pageSize=1000');
  const passages = [];
  for (const { name: session } of sessions) {
    for (const verdict of (await system.call(`${session}/doorVerdicts`)).verdicts ?? []) {
      if (!verdict.comparisons?.length) continue;
      const { seen = [], kept = [] } = await system.call(`${verdict.name}/images`);
      if (seen.length > 4 && kept[0]?.images?.length) passages.push({ session, verdict, images: { seen, kept } });
    }
  }
  assert.ok(passages.length > 0, 'a passage has images to compare');
  return passages.reduce((a, b) => (b.verdict.comparisons.length > a.verdict.comparisons.length ? b : a));
}

export function addSessions({ system, browser, at, campus }) {
  test('trajectory: a slider shows where the robot was at each moment, on the session\'s map', async () => {
    await campus();
    const { sessions } = await system.call('sites/demo/sessions?pageSize=1000');
    const driven = [];
    for (const { name } of sessions) driven.push({ name, trajectory: await trajectoryOf(system, name) });
    const { name, trajectory } = driven.reduce((a, b) => (b.trajectory.length > a.trajectory.length ? b : a));
    assert.ok(trajectory.length > 20, `${trajectory.length} poses`);
    const address = at(`demo/sessions/${idOf(name)}`);
    const { page, close } = await open(browser(), address);
    const slider = page.getByRole('slider', { name: 'Time in the session' });
    await slider.waitFor();
    await settled(page);
    const end = trajectory.at(-1).time;
    assert.ok(Math.abs(Number(await slider.getAttribute('max')) - end) <= 0.05, 'the slider ends with the drive');
    // The slider has steps of 0.1 s; the pose is the last one that is not later.
    const expected = (value) => trajectory.findLast(({ time }) => time <= value + 0.05) ?? trajectory[0];
    await slider.focus();
    for (const [key, times] of [['Home', 1], ['ArrowRight', 17], ['PageUp', 2], ['ArrowLeft', 5], ['End', 1]]) {
      for (let i = 0; i < times; ++i) await page.keyboard.press(key);
      const value = Number(await slider.inputValue());
      const { pose } = expected(value);
      await until(`the robot is drawn where it was after ${value} s (${key})`, async () => await awayFrom(page, pose) < 1);
      const text = await slider.getAttribute('aria-valuetext');
      assert.ok(text.startsWith(`${value.toFixed(1)} s`) && text.includes(`${pose.x.toFixed(2)}, ${pose.y.toFixed(2)} m`), text);
    }
    const { size, camera, marks } = await sceneOf(page);
    const way = marks.find(({ kind }) => kind === 'path');
    assert.ok(distance(way.from, toScreen(camera, size, trajectory[0].pose)) < 1 && distance(way.to, toScreen(camera, size, trajectory.at(-1).pose)) < 1);
    await picture(page, 'session-trajectory');

    // The address brings a moment back, and the drive plays on from there.
    const middle = (Math.round(10 * (end / 2)) / 10).toString();
    await page.goto(`${address}?t=${middle}`);
    await until('the moment of the address is drawn', async () => await awayFrom(page, expected(Number(middle)).pose) < 1);
    await page.getByLabel('Speed').selectOption('20');
    await page.getByRole('button', { name: 'Play' }).focus();
    await page.keyboard.press('Enter');
    await until('it has played to its end', async () => await awayFrom(page, trajectory.at(-1).pose) < 1);
    await page.getByRole('button', { name: 'Play' }).waitFor();
    await close();
  });

  test('trajectory: a session of which nothing is mapped says so', async () => {
    system.enfilade('drives', 'site', 'create', 'drives');
    await system.call('sites/drives/maps?mapId=m', { displayName: 'm' });
    await system.call('sites/drives/robots?robotId=r', { displayName: 'r' });
    const { session } = await system.call('sites/drives/sessions', { robot: 'sites/drives/robots/r', map: 'sites/drives/maps/m' });
    const { page, close } = await open(browser(), at(`drives/sessions/${idOf(session.name)}`));
    await page.getByText('No scan of this session has been mapped yet.').waitFor();
    await page.getByText('None: the robot reported no door in this session.').waitFor();
    assert.deepEqual(await faultsOf(page), []);
    await close();
  });

  test('door_images: a verdict shows what the robot saw beside what was kept of the place, and what each sense says', async () => {
    await campus();
    const { session, verdict, images } = await comparedVerdict(system);
    const shas = (list = []) => list.map(hexOf);
    const { page, close } = await open(browser(), at(`demo/sessions/${idOf(session)}`), { expected: /Failed to load resource/ });
    const item = page.locator('li.verdict').filter({ hasText: verdict.reason });
    const best = item.getByRole('list', { name: 'Compared with' }).locator(':scope > li').first();
    const [comparison] = verdict.comparisons;
    await best.getByText(comparison.reason).waitFor();
    const matches = comparison.imageMatches < 0 ? 'none to compare' : `${comparison.imageMatches} match`;
    await best.locator('dd').filter({ hasText: matches }).first().waitFor();
    const shown = (region) => best.getByRole('region', { name: region }).locator('img').evaluateAll((all) => all.map((image) => image.src.split('/').pop()));
    const kept = images.kept[0].images;
    await until('the first images are shown', async () => (await shown('What the robot saw')).length === 4);
    assert.deepEqual(await shown('What the robot saw'), shas(images.seen).slice(0, 4));
    assert.deepEqual(await shown(/What is kept of this place/), shas(kept).slice(0, 4));
    await best.getByRole('button', { name: `All ${images.seen.length}` }).focus();
    await page.keyboard.press('Enter');
    assert.deepEqual(await shown('What the robot saw'), shas(images.seen));
    const pictures = best.locator('img');
    for (let i = 0; i < await pictures.count(); ++i) {
      await pictures.nth(i).scrollIntoViewIfNeeded();
      await until('the image is loaded', () => pictures.nth(i).evaluate((image) => image.complete && image.naturalWidth > 100));
    }
    await picture(page, 'session-images');
    // Another comparison is opened by the keyboard.
    if (verdict.comparisons.length > 1) {
      const second = item.getByRole('list', { name: 'Compared with' }).locator(':scope > li').nth(1);
      await second.locator('summary').focus();
      await page.keyboard.press('Enter');
      await second.getByText(verdict.comparisons[1].reason).waitFor();
      if ((images.kept[1].images ?? []).length === 0) await second.getByText('No images are kept of this place.').waitFor();
    }
    // An image that is gone.
    await page.route('**/blobs/*', (route) => route.fulfill({ status: 404 }));
    await page.reload();
    await best.getByText('This picture is no longer stored.').first().waitFor();
    assert.deepEqual(await faultsOf(page), []);
    await close();
  });

  test('session: fits a phone, in both themes', async () => {
    await campus();
    const { session } = await comparedVerdict(system);
    for (const theme of ['light', 'dark']) {
      const { page, close } = await open(browser(), at(`demo/sessions/${idOf(session)}`), { theme, width: 390, height: 780 });
      await page.getByRole('slider', { name: 'Time in the session' }).waitFor();
      await settled(page);
      assert.ok(await page.evaluate(() => document.querySelector('main').scrollWidth <= innerWidth), 'nothing sticks out');
      assert.deepEqual(await faultsOf(page), [], theme);
      await picture(page, `session-phone-${theme}`);
      await close();
    }
  });
}

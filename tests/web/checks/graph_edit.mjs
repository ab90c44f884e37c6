// SPDX-License-Identifier: Apache-2.0
// Link points changed by hand on the campus.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { test } from 'node:test';
import { PNG } from 'pngjs';
import { drawnMaps, faultsOf, open, picture, settled } from '../browser.mjs';
import { anchor, corridors, moveDoor, overlapping, threeDoors, twoRooms } from '../maps.mjs';
import { distance, placed, sceneOf, seenFrom, toScreen } from '../pixels.mjs';
import { until } from '../system.mjs';

const middle = { x: 5, y: 5 };
export const graphOf = async (system, site) => (await system.call(`sites/${site}/graph`)).graph;
const poseOf = async (system, site, map) => (await graphOf(system, site)).maps.find((one) => one.map === `sites/${site}/maps/${map}`).poseWorldMap.pose;
const linkPointOf = async (system, site, id) => (await system.call(`sites/${site}/linkPoints/${id}`)).linkPoint;
const anchorIn = ({ anchors }, map) => anchors.find((one) => one.map.endsWith(`/${map}`)).poseMapPlace;
const inverse = (pose) => { const { x, y } = seenFrom(pose, { x: 0, y: 0 }); return { x, y, yaw: -(pose.yaw ?? 0) }; };
const chained = (a, b) => ({ ...placed(a, { x: b.x ?? 0, y: b.y ?? 0 }), yaw: (a.yaw ?? 0) + (b.yaw ?? 0) });

// v' S^-1 v of a 3x3 covariance, row by row.
function mahalanobis(v, [a, b, c, , e, f, , , i]) {
  const det = a * (e * i - f * f) - b * (b * i - f * c) + c * (b * f - e * c);
  const inverted = [[e * i - f * f, c * f - b * i, b * f - c * e], [c * f - b * i, a * i - c * c, b * c - a * f], [b * f - c * e, b * c - a * f, a * e - b * b]];
  return inverted.reduce((sum, row, k) => sum + v[k] * row.reduce((part, value, l) => part + value * v[l], 0), 0) / det;
}

// The campus with the graph being edited and one thing selected.
export async function edit(stage, site, selection, options, count = 2) {
  const opened = await open(stage.browser(), stage.at(`${site}/campus?sel=${encodeURIComponent(selection)}`), options);
  const { page } = opened;
  await until('the maps are drawn', async () => (await drawnMaps(page)).length >= count);
  await settled(page);
  await page.locator('.scene-canvas').press('e');
  await page.getByRole('heading', { name: 'Edit the graph' }).waitFor();
  return opened;
}

const grip = (page, what, map) => page.getByRole('button', { name: new RegExp(`^${what} in ${map}:`) });

async function middleOf(locator) {
  const { x, y, width, height } = await locator.boundingBox();
  return { x: x + width / 2, y: y + height / 2 };
}

// Takes a handle and pulls it by pixels; lets go unless `isHeld`.
async function drag(page, handle, dx, dy, isHeld = false) {
  const from = await middleOf(handle);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 10; ++i) await page.mouse.move(from.x + (dx * i) / 10, from.y + (dy * i) / 10);
  if (!isHeld) await page.mouse.up();
}

const ghosts = async (page) => (await drawnMaps(page)).filter(({ ghost }) => ghost);
const mapIn = async (page, name) => (await drawnMaps(page)).find((one) => one.name === name && !one.ghost);
const previewed = (page) => page.locator('section[aria-label=Preview][aria-busy=false]').waitFor();
const save = (page, name = 'Save') => page.getByRole('button', { name, exact: true });
const saved = (page) => page.getByText(/^Saved as version /).waitFor();

export function addGraphEdit(stage) {
  const { system, at, browser } = stage;

  test('drag_link_point: an anchor is dragged with a preview, and stored with what a hand knows of it', async () => {
    const site = 'dragged';
    await twoRooms(system, site);
    const before = await linkPointOf(system, site, 'door');
    const { page, close } = await edit(stage, site, 'linkPoints/door');
    const asked = [];
    page.on('request', (request) => request.method() !== 'GET' && asked.push(`${request.method()} ${new URL(request.url()).pathname}`));
    const { camera, size } = await sceneOf(page);
    const poseB = await poseOf(system, site, 'b');
    await drag(page, grip(page, 'Place of the anchor', 'b'), 30, -20, true);
    await until('the map is previewed while it is dragged', async () => (await ghosts(page)).length === 1);
    const [ghost] = await ghosts(page);
    assert.ok(distance(ghost, toScreen(camera, size, placed(poseB, middle))) < 1, 'the ghost is where the map is');
    await picture(page, 'graph-drag');
    await page.mouse.up();
    await previewed(page);
    await page.getByText(/1 map moves, b the farthest: /).waitFor();
    assert.deepEqual(asked.filter((path) => !path.endsWith(':previewGraph')), [], 'nothing but previews before it is saved');
    assert.deepEqual(await faultsOf(page), []);

    await save(page).click();
    await saved(page);
    const after = await linkPointOf(system, site, 'door');
    const moved = anchorIn(after, 'b');
    const wanted = seenFrom(poseB, { x: placed(poseB, anchorIn(before, 'b').pose).x + 30 / camera.scale, y: placed(poseB, anchorIn(before, 'b').pose).y + 20 / camera.scale });
    assert.ok(distance(moved.pose, wanted) < 1.5 / camera.scale, `${JSON.stringify(moved.pose)} is where it was dropped`);
    [0.01, 0, 0, 0, 0.01, 0, 0, 0, (2 * Math.PI / 180) ** 2].forEach((value, i) => assert.ok(Math.abs(moved.covariance[i] - value) < 1e-12, `covariance[${i}]`));
    assert.deepEqual(anchorIn(after, 'a'), anchorIn(before, 'a'), 'the other anchor is untouched');
    assert.deepEqual(asked.filter((path) => !path.endsWith(':previewGraph')), [`POST /v1/sites/${site}:changeGraph`], 'poses of maps are not written');
    const expected = chained(anchorIn(after, 'a').pose, inverse(moved.pose));
    await until('the optimisation has moved the map to where the anchors meet', async () => distance(await poseOf(system, site, 'b'), expected) < 0.001);
    await until('and it is drawn there', async () => distance(await mapIn(page, `sites/${site}/maps/b`), toScreen(camera, size, placed(expected, middle))) < 1);
    await close();
  });

  test('drag_link_point: what is placed by hand is pinned, until a person gives it back to surveys', async () => {
    const site = 'pinned';
    await twoRooms(system, site);
    const { page, close } = await edit(stage, site, 'linkPoints/door');
    const pin = page.getByLabel('Pinned: surveys leave it as it is');
    assert.ok(await pin.isChecked(), 'people have made it');
    await pin.uncheck();
    // The handles stay while the link point is read in the new version of the graph.
    let release = () => {};
    const held = new Promise((resolve) => (release = resolve));
    const read = page.waitForRequest(`**/v1/sites/${site}/linkPoints/door`);
    await page.route(`**/v1/sites/${site}/linkPoints/door`, async (route) => { await held; await route.continue(); });
    await save(page).click();
    await saved(page);
    assert.ok(!(await linkPointOf(system, site, 'door')).pinned);
    await read;
    await drag(page, grip(page, 'Place of the anchor', 'b'), 30, -20);
    await previewed(page);
    assert.ok(await pin.isChecked(), 'a drag pins it');
    release();
    await save(page).click();
    await until('it is stored so', async () => (await linkPointOf(system, site, 'door')).pinned);
    await close();
  });

  test('drag_link_point: the ellipse and the wedge are pulled, entered and taken from presets', async () => {
    const site = 'spread';
    await twoRooms(system, site);
    const { page, close } = await edit(stage, site, 'linkPoints/door');
    const form = page.getByRole('group', { name: 'Anchor in b' });
    await form.getByRole('button', { name: 'Measured: 2 cm, 0.5°' }).click();
    await drag(page, grip(page, 'Longer axis of the ellipse', 'b'), 40, 0);
    assert.ok(Number(await form.getByLabel('σ longer axis, m').inputValue()) > 0.02, 'the axis has been pulled');
    await form.getByLabel('σ longer axis, m').fill('0.4');
    await form.getByLabel('σ shorter axis, m').fill('0.1');
    await form.getByLabel('Longer axis at, °').fill('90');
    await form.getByLabel('σ direction, °').fill('4');
    await picture(page, 'graph-ellipse');
    await previewed(page);
    await save(page).click();
    await saved(page);
    const { covariance } = anchorIn(await linkPointOf(system, site, 'door'), 'b');
    [0.01, 0, 0, 0, 0.16, 0, 0, 0, (4 * Math.PI / 180) ** 2].forEach((value, i) => assert.ok(Math.abs(covariance[i] - value) < 1e-9, `covariance[${i}] is ${covariance[i]}`));
    await close();
  });

  test('drag_link_point: a drag that contradicts is named before it is saved, by the keyboard alone', async () => {
    const site = 'against';
    await threeDoors(system, site);
    const { page, close } = await edit(stage, site, 'linkPoints/door');
    const handle = grip(page, 'Place of the anchor', 'b');
    await handle.focus();
    await handle.press('ArrowUp');
    const form = page.getByRole('group', { name: 'Anchor in b' });
    await form.getByLabel('y, m').focus();
    await page.keyboard.press('Control+A');
    await page.keyboard.type('9.5');
    const off = page.getByText(/^Door a – b \(door\) is switched off: chi-squared [\d.]+ > 16\.3$/);
    await off.waitFor();
    await previewed(page);
    const chi2 = Number(/([\d.]+) > /.exec(await off.textContent())[1]);
    assert.ok(chi2 > 16.3, `chi-squared ${chi2}`);
    assert.ok((await graphOf(system, site)).linkPoints.every(({ use }) => use === 'USE_USED'), 'nothing is switched off yet');
    await picture(page, 'graph-contradiction');
    assert.deepEqual(await faultsOf(page), []);
    await save(page, 'Save although 1 link point is switched off').focus();
    await page.keyboard.press('Enter');
    await saved(page);
    await until('the optimisation does as the preview said', async () => (await linkPointOf(system, site, 'door')).use === 'USE_SWITCHED_OFF');
    await close();
  });

  test('drag_link_point: of two people the second one sees what the first one has changed, and loses nothing', async () => {
    const site = 'both';
    await twoRooms(system, site);
    const first = await edit(stage, site, 'linkPoints/door');
    const second = await edit(stage, site, 'linkPoints/door', { expected: /409/ });
    await drag(second.page, grip(second.page, 'Place of the anchor', 'b'), 0, -40);
    await previewed(second.page);
    // The second one does not hear of it in time.
    let release = () => {};
    const held = new Promise((resolve) => (release = resolve));
    await second.page.route(`**/v1/sites/${site}/linkPoints/door`, async (route) => { await held; await route.continue(); });
    await first.page.getByLabel('Drag in the frame of').getByLabel('a', { exact: true }).check();
    await first.page.getByRole('group', { name: 'Anchor in a' }).getByLabel('y, m').fill('5.3');
    await previewed(first.page);
    await save(first.page).click();
    await saved(first.page);
    const refused = second.page.waitForResponse((response) => response.url().endsWith(':changeGraph'));
    await save(second.page).click();
    assert.equal((await refused).status(), 409);
    assert.equal(anchorIn(await linkPointOf(system, site, 'door'), 'b').covariance[0], 0.0015, 'nothing of the second one is stored');
    release();
    const notice = second.page.getByRole('alert', { name: /^Changed by somebody else: Door a – b/ });
    await notice.getByText('Anchor in a: moved by 30.0 cm, 0.00°').waitFor();
    await picture(second.page, 'graph-conflict');
    assert.deepEqual(await faultsOf(second.page), []);
    await notice.getByRole('button', { name: 'Keep mine on top' }).click();
    await previewed(second.page);
    await save(second.page).click();
    await saved(second.page);
    const both = await linkPointOf(system, site, 'door');
    assert.ok(Math.abs(anchorIn(both, 'a').pose.y - 5.3) < 1e-9, 'the change of the first one is kept');
    assert.ok(Math.abs(anchorIn(both, 'b').covariance[0] - 0.01) < 1e-12, 'and so is that of the second one');
    await first.close();
    await second.close();
  });

  test('drag_link_point: a version of the graph that comes during a drag waits for its end', async () => {
    const site = 'waits';
    await twoRooms(system, site);
    const { page, close } = await edit(stage, site, 'linkPoints/door', { expected: /409/ });
    const { camera, size } = await sceneOf(page);
    const before = await poseOf(system, site, 'b');
    await drag(page, grip(page, 'Direction of the anchor', 'b'), 4, 4, true);
    await until('it is previewed', async () => (await ghosts(page)).length === 1);
    await moveDoor(system, site, { x: 10, y: 8, yaw: 0.3 });
    const after = await poseOf(system, site, 'b');
    assert.ok(distance(after, before) > 1);
    await page.getByText(/^Version \d+ of the graph has come/).waitFor();
    assert.ok(distance((await ghosts(page))[0], toScreen(camera, size, placed(before, middle))) < 1, 'the drag goes on in the frame in which it began');
    await page.mouse.up();
    await page.getByRole('alert', { name: /^Changed by somebody else/ }).getByRole('button', { name: 'Load theirs, drop mine' }).click();
    await until('then it is applied', async () => distance(await mapIn(page, `sites/${site}/maps/b`), toScreen(camera, size, placed(after, middle))) < 1);
    assert.equal((await ghosts(page)).length, 0);
    await close();
  });

  test('drag_link_point: what was saved is taken back from the audit trail', async () => {
    const site = 'taken-back';
    await twoRooms(system, site);
    const before = await linkPointOf(system, site, 'door');
    const { page, close } = await edit(stage, site, 'linkPoints/door');
    await drag(page, grip(page, 'Place of the anchor', 'b'), 25, 0);
    await page.getByRole('button', { name: 'Suspend', exact: true }).click();
    await until('the preview has it', () => page.getByText(/^No place in the world: b$/).isVisible());
    await previewed(page);
    await save(page, 'Save although 1 map loses its place').click();
    await saved(page);
    assert.equal((await linkPointOf(system, site, 'door')).use, 'USE_SUSPENDED');
    await page.goto(at(`${site}/history/audit`));
    await page.getByRole('button', { name: 'Take back: Changed linkPoints/door/anchors/b' }).first().click();
    const question = page.getByRole('group', { name: 'Take this change back?' });
    await question.getByText(/its anchor in b goes back to 0\.00, 5\.00 m$/).waitFor();
    await question.getByText('Door a – b is resumed').waitFor();
    await picture(page, 'graph-take-back');
    assert.deepEqual(await faultsOf(page), []);
    await question.getByRole('button', { name: 'Take it back' }).click();
    await question.waitFor({ state: 'detached' });
    const after = await linkPointOf(system, site, 'door');
    assert.deepEqual(after.anchors, before.anchors);
    assert.notEqual(after.use, 'USE_SUSPENDED');
    const { entries } = await system.call(`sites/${site}/auditEntries?resource=sites/${site}/linkPoints/door/anchors/b`);
    assert.equal(entries.length, 3, 'made, dragged and taken back');

    // Deleted, and made again under its name.
    await page.goto(at(`${site}/campus?edit=graph&sel=linkPoints/door`));
    await page.getByRole('button', { name: 'Delete', exact: true }).click();
    await previewed(page);
    await save(page, 'Save although 1 map loses its place').click();
    await saved(page);
    await page.goto(at(`${site}/history/audit`));
    await page.getByRole('button', { name: 'Take back: Deleted linkPoints/door', exact: true }).click();
    await page.getByRole('group', { name: 'Take this change back?' }).getByRole('button', { name: 'Take it back' }).click();
    await until('it is there again', async () => (await graphOf(system, site)).linkPoints.length === 1);
    assert.deepEqual((await linkPointOf(system, site, 'door')).anchors, before.anchors);
    await close();
  });

  test('align: two maps that overlap are found from a wrong guess, and become a link point', async () => {
    const site = 'aligned';
    const truth = { x: 3.1, y: 1.7, yaw: 0.4 };
    await overlapping(system, site, truth);
    const { page, close } = await open(browser(), at(`${site}/campus?edit=graph&sel=maps/a`));
    await page.getByLabel('With another map of its level').selectOption({ label: 'b' });
    await page.getByRole('button', { name: 'Align', exact: true }).click();
    const panel = page.getByRole('region', { name: 'Align two maps' });
    const wrong = 3 / Math.SQRT2;
    await panel.getByLabel('x, m', { exact: true }).fill(String(truth.x + wrong));
    await panel.getByLabel('y, m', { exact: true }).fill(String(truth.y - wrong));
    await panel.getByLabel('Direction, °').fill(String((truth.yaw * 180) / Math.PI + 20));
    await picture(page, 'graph-align-guess');
    const answered = page.waitForResponse((response) => response.url().endsWith(':align'));
    await panel.getByRole('button', { name: 'Find the place' }).click();
    await panel.getByText('The maps fit here, and nowhere else').waitFor({ timeout: 60_000 });
    const { poseAB } = await (await answered).json();
    const off = [poseAB.pose.x - truth.x, poseAB.pose.y - truth.y, poseAB.pose.yaw - truth.yaw];
    const chi2 = mahalanobis(off, poseAB.covariance);
    assert.ok(chi2 < 16.27, `its covariance contains the truth: chi-squared ${chi2}`); // 99.9 % of 3 degrees of freedom
    await picture(page, 'graph-align-found');
    assert.deepEqual(await faultsOf(page), []);
    const found = { x: Number(await panel.getByLabel('x, m', { exact: true }).inputValue()), y: Number(await panel.getByLabel('y, m', { exact: true }).inputValue()), yaw: (Number(await panel.getByLabel('Direction, °').inputValue()) * Math.PI) / 180 };
    assert.ok(distance(found, truth) < 0.05, `${JSON.stringify(found)} is within 0.05 m`);
    assert.ok(Math.abs(found.yaw - truth.yaw) < (0.5 * Math.PI) / 180, `${found.yaw} is within 0.5°`);
    await panel.getByRole('button', { name: 'Make a link point' }).click();
    await page.getByText('Placed now: b').waitFor();
    await previewed(page);
    await picture(page, 'graph-align-preview');
    await save(page).click();
    await saved(page);
    const { linkPoints } = await graphOf(system, site);
    assert.equal(linkPoints.length, 1);
    const made = await linkPointOf(system, site, linkPoints[0].linkPoint.split('/').pop());
    const joint = chained(anchorIn(made, 'a').pose, inverse(anchorIn(made, 'b').pose));
    assert.ok(distance(joint, found) < 0.001 && made.anchors.length === 2, 'its anchors say what the fit says');
    await close();
  });

  test('align: maps that look alike at several places are refused, with the reason', async () => {
    const site = 'corridors';
    await corridors(system, site);
    const { page, close } = await open(browser(), at(`${site}/campus?edit=graph&sel=maps/a`));
    await page.getByLabel('With another map of its level').selectOption({ label: 'b' });
    await page.getByRole('button', { name: 'Align', exact: true }).click();
    const panel = page.getByRole('region', { name: 'Align two maps' });
    await panel.getByRole('button', { name: 'Find the place' }).click();
    await panel.getByText(/^Not accepted: ./).waitFor({ timeout: 60_000 });
    assert.ok(await panel.getByRole('button', { name: 'Make a link point' }).isDisabled());
    await picture(page, 'graph-align-refused');
    await close();
  });

  test('candidates: the inbox shows what was seen of a door, which is promoted, and others are deleted', async () => {
    const site = 'inbox';
    await twoRooms(system, site);
    for (const [id, y] of [['seen', 2], ['ghost', 8]]) await system.call(`sites/${site}/linkPoints?linkPointId=${id}`, { kind: 'KIND_DOOR', anchors: [anchor(site, 'a', { x: 10, y })] });
    const photo = new PNG({ width: 64, height: 48 });
    photo.data.fill(200);
    const bytes = PNG.sync.write(photo);
    const form = new FormData();
    form.append('evidence', JSON.stringify({ map: `sites/${site}/maps/a`, image: { camera: 'CAMERA_FRONT', encoding: 'ENCODING_PNG', time: '2026-11-26T06:00:00Z', content: { sha256: createHash('sha256').update(bytes).digest('base64'), sizeBytes: String(bytes.length) } } }));
    form.append('file', new Blob([bytes]), 'door.png');
    const attached = await fetch(`${system.url}/v1/sites/${site}/linkPoints/seen/evidence`, { method: 'POST', body: form });
    assert.equal(attached.status, 200, await attached.text());
    const { page, close } = await open(browser(), at(`${site}/linkPoints/candidates`));
    const list = page.getByRole('list', { name: 'Candidates' });
    await until('both are listed', async () => (await list.getByRole('listitem').count()) === 2);
    await page.getByLabel('Pictures').selectOption('with');
    await until('one is listed', async () => (await list.getByRole('listitem').count()) === 1);
    await until('its picture has come', () => list.getByRole('img').evaluate((image) => image.naturalWidth === 64));
    await picture(page, 'graph-candidates');
    assert.deepEqual(await faultsOf(page), []);
    await page.getByLabel('Pictures').selectOption('without');
    await until('the other is listed', async () => (await list.getByRole('img').count()) === 0 && (await list.getByRole('listitem').count()) === 1);
    await page.getByLabel('All that are listed').check();
    await page.getByRole('button', { name: 'Delete …' }).click();
    await page.getByRole('button', { name: 'Delete them' }).click();
    await until('it is gone', async () => (await graphOf(system, site)).linkPoints.length === 2);
    await page.getByLabel('Pictures').selectOption('all');
    await list.getByRole('link', { name: 'Promote …' }).click();
    await page.getByLabel('It leads to').selectOption({ label: 'b' });
    await page.getByRole('button', { name: 'Promote: add the anchor' }).click();
    await previewed(page);
    await picture(page, 'graph-promote');
    await save(page).click();
    await saved(page);
    const promoted = await linkPointOf(system, site, 'seen');
    const inWorld = placed(await poseOf(system, site, 'b'), anchorIn(promoted, 'b').pose);
    assert.ok(distance(inWorld, { x: 10, y: 2 }) < 0.01, 'the anchor in b is where the candidate is in the world');
    await close();
  });

  test('drag_link_point: a link point is suspended and resumed', async () => {
    const site = 'resumed';
    await twoRooms(system, site);
    const { page, close } = await edit(stage, site, 'linkPoints/door');
    await page.getByRole('button', { name: 'Suspend', exact: true }).click();
    await previewed(page);
    await save(page, 'Save although 1 map loses its place').click();
    await saved(page);
    await until('the map has lost its place', async () => (await graphOf(system, site)).maps.some(({ poseWorldMap }) => !poseWorldMap));
    assert.equal((await linkPointOf(system, site, 'door')).use, 'USE_SUSPENDED');
    await page.getByRole('button', { name: 'Resume', exact: true }).click();
    await page.getByText('Placed now: b').waitFor();
    await previewed(page);
    await save(page).click();
    await until('both have one again', async () => (await graphOf(system, site)).maps.every(({ poseWorldMap }) => poseWorldMap));
    assert.equal((await linkPointOf(system, site, 'door')).use, 'USE_USED');
    await close();
  });
}

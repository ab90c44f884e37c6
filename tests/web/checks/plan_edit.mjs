// SPDX-License-Identifier: Apache-2.0
// People correct the walls of a plan, with the pointer and by keys; and what the correction by maps has moved. Goes on
// where plans.mjs ends: the site has an active plan.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, faultsOf, open, picture, settled } from '../browser.mjs';
import { distance, look, pixelsOf } from '../pixels.mjs';
import { until } from '../system.mjs';

const SITE = 'plans';

const planOf = async (system) => (await system.call(`sites/${SITE}/priorMaps`)).priorMaps.find(({ displayName }) => displayName === 'Ground floor');
const fileOf = async (system, file) => (await fetch(`${system.url}/v1/${(await planOf(system)).name}/files/${file}`)).json();
const linesOf = ({ features }, kind) =>
  features.filter(({ properties }) => properties.kind === kind)
    .map(({ geometry: { coordinates: [[x0, y0], [x1, y1]] }, properties }) => ({ from: { x: x0, y: y0 }, to: { x: x1, y: y1 }, length: Math.hypot(x1 - x0, y1 - y0), properties }));
const middle = ({ from, to }) => ({ x: (from.x + to.x) / 2, y: (from.y + to.y) / 2 });
const nearest = (points, at) => Math.min(...points.map((p) => distance(p, at)));

// Where a point of the sheet is in the window.
const onBoard = (page, { x, y }) =>
  page.locator('.board-window svg').evaluate((svg, at) => {
    const box = svg.getBoundingClientRect();
    const frame = svg.viewBox.baseVal;
    return { x: box.left + ((at.x - frame.x) / frame.width) * box.width, y: box.top + ((at.y - frame.y) / frame.height) * box.height };
  }, { x, y });
const clickBoard = async (page, at) => { const { x, y } = await onBoard(page, at); await page.mouse.click(x, y); };
const unitsPerPx = (page) => page.locator('.board-window svg').evaluate((svg) => svg.viewBox.baseVal.width / svg.getBoundingClientRect().width);

export function addPlanEdit({ system, browser, at }) {
  test('plans: walls are corrected on the sheet, saved at once, and the plan is aligned again', async () => {
    const before = await planOf(system);
    assert.equal(before.state, 'STATE_PROPOSED', 'the tests before this one have aligned it');
    const stored = await fileOf(system, 'plan.geojson');
    const walls = linesOf(stored, 'wall');
    const { page, close } = await open(browser(), at(`${SITE}/plans/${before.name.split('/').pop()}`));
    await page.getByRole('link', { name: 'Correct walls' }).click();
    const details = page.getByRole('complementary', { name: 'Details' });
    await details.getByText(`${walls.length} walls`).waitFor();
    const save = page.getByRole('button', { name: 'Save' });
    assert.ok(await save.isDisabled(), 'nothing is changed yet');

    // The longest wall goes, comes back, and goes again.
    const longest = [...walls].sort((a, b) => b.length - a.length)[0];
    await clickBoard(page, middle(longest));
    await page.getByRole('status').filter({ hasText: /^Wall of/ }).waitFor();
    await picture(page, 'plan-edit-selected');
    assert.deepEqual(await faultsOf(page), []);
    await details.getByRole('button', { name: 'Delete the wall' }).click();
    await details.getByText(`${walls.length - 1} walls`).waitFor();
    await page.keyboard.press('Control+z');
    await details.getByText(`${walls.length} walls`).waitFor();
    await page.keyboard.press('Control+y');
    await details.getByText(`${walls.length - 1} walls`).waitFor();

    // A wall that is clicked beside two corners begins and ends at them.
    await page.getByRole('button', { name: 'Draw walls' }).click();
    const px = await unitsPerPx(page);
    await clickBoard(page, { x: longest.from.x + 4 * px, y: longest.from.y - 3 * px });
    const end = await onBoard(page, longest.to);
    await page.mouse.move(end.x - 5, end.y + 2);
    await picture(page, 'plan-edit-drawing');
    await page.mouse.click(end.x - 3, end.y + 4);
    await page.keyboard.press('Escape');
    await details.getByText(`${walls.length} walls`).waitFor();

    // A door in the middle of the second longest wall.
    const second = [...walls].sort((a, b) => b.length - a.length)[1];
    const along = { x: (second.to.x - second.from.x) / second.length, y: (second.to.y - second.from.y) / second.length };
    const jambs = [-12, 12].map((d) => ({ x: middle(second).x + d * along.x, y: middle(second).y + d * along.y }));
    await page.keyboard.press('d');
    for (const jamb of jambs) await clickBoard(page, jamb);
    const doors = linesOf(stored, 'door').length;
    await details.getByText(`${doors + 1} doors`).waitFor();

    // A corner is dragged, without snapping.
    await page.keyboard.press('v');
    const corner = longest.from;
    const [from, to] = [await onBoard(page, corner), await onBoard(page, { x: corner.x + 11 * px, y: corner.y + 14 * px })];
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    await page.mouse.move(to.x, to.y, { steps: 4 });
    await picture(page, 'plan-edit-dragging');
    await page.keyboard.down('Alt');
    await page.mouse.up();
    await page.keyboard.up('Alt');
    await page.getByRole('status').filter({ hasText: /^Corner of/ }).waitFor();

    // By keys: the first wall becomes thicker.
    await page.locator('.board-window').focus();
    await page.keyboard.press('Escape');
    await page.keyboard.press('n');
    await page.getByRole('status').filter({ hasText: /^Wall of/ }).waitFor();
    await details.getByLabel('Thickness').fill('9');
    await details.getByRole('button', { name: 'Change' }).click();
    await picture(page, 'plan-edit-changed');

    assert.equal((await planOf(system)).etag, before.etag, 'nothing is sent before it is saved');
    // Leaving the page and coming back loses nothing.
    await page.getByRole('link', { name: 'Back to the plan' }).click();
    await page.getByRole('link', { name: 'Correct walls' }).click();
    await details.getByText(`${doors + 1} doors`).waitFor();
    await page.keyboard.press('Control+s');
    await details.getByText(/^Saved: .*walls? added/).waitFor();
    await picture(page, 'plan-edit-saved');
    assert.deepEqual(await faultsOf(page), []);
    const after = await planOf(system);
    assert.equal(after.state, 'STATE_NEW');
    assert.match(after.reason, /align it again/);
    const edited = await fileOf(system, 'plan.geojson');
    const ends = linesOf(edited, 'wall').flatMap((wall) => [wall.from, wall.to]);
    for (const jamb of jambs) assert.ok(nearest(ends, jamb) < 2 * px, 'the wall ends at the jambs');
    assert.ok(!linesOf(edited, 'wall').some((wall) => distance(middle(wall), middle(second)) < 6), 'and there is a gap between them');
    assert.ok(nearest(ends, corner) > 0.01, 'the corner is gone from where it was');
    assert.ok(nearest(ends, { x: corner.x + 11 * px, y: corner.y + 14 * px }) < 2 * px);
    assert.equal(linesOf(edited, 'wall').filter(({ properties }) => properties.thickness === 9).length, 1);

    // It is put back, and aligned again.
    await page.getByRole('link', { name: 'Back to the plan' }).click();
    await page.getByText('Alignment before it was corrected').waitFor();
    await picture(page, 'plan-corrected');
    assert.ok(await page.getByRole('button', { name: 'Activate' }).isDisabled());
    await system.call(`${after.name}:edit`, { plan: JSON.stringify(stored), etag: after.etag });
    await page.reload();
    await page.getByRole('button', { name: 'Align again' }).click();
    await page.getByText(/^Accepted: fits where it was placed before/).waitFor({ timeout: 120_000 });
    assert.equal((await planOf(system)).state, 'STATE_PROPOSED');
    await close();
  });

  test('plans: who uses no pointer draws a wall, and whoever else corrects the plan meanwhile is not overwritten', async () => {
    const before = await planOf(system);
    const { walls: count } = before.elements;
    const { page, close } = await open(browser(), at(`${SITE}/plans/${before.name.split('/').pop()}/walls`), { theme: 'dark', expected: /409|status of 409/ });
    const details = page.getByRole('complementary', { name: 'Details' });
    await details.getByText(`${count} walls`).waitFor();
    await page.locator('.board-window').focus();
    await page.keyboard.press('w');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('Enter');
    for (let i = 0; i < 4; ++i) await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Alt+Enter');
    await details.getByText(`${count + 1} walls`).waitFor();
    await page.keyboard.press('Escape');
    assert.deepEqual(await faultsOf(page), []);
    await picture(page, 'plan-edit-keys-dark');
    // Somebody else gives it a scale.
    await system.call(`${before.name}:edit`, { measure: { toX: 100, lengthM: 5 }, etag: before.etag });
    await page.getByText('Somebody has corrected this plan meanwhile').waitFor({ timeout: 30_000 });
    assert.ok(await page.getByRole('button', { name: 'Save' }).isDisabled());
    await page.getByRole('button', { name: 'Discard' }).click();
    await page.getByRole('button', { name: 'Discard it' }).click();
    await details.getByText(`${count} walls`).waitFor();
    await details.getByText('0.05000 m per unit').waitFor();
    // A distance that is known gives another scale.
    await page.getByRole('button', { name: 'Measure' }).click();
    await page.keyboard.down('Alt');
    for (const x of [100, 200]) await clickBoard(page, { x, y: 3 });
    await page.keyboard.up('Alt');
    await details.getByLabel('Distance, m').fill('4');
    await details.getByRole('button', { name: 'Set the scale' }).click();
    await page.keyboard.press('Control+s');
    await details.getByText('Saved: another scale').waitFor();
    const { elements: { metresPerUnit } } = await planOf(system);
    assert.ok(Math.abs(metresPerUnit / 0.04 - 1) < 0.05, `${metresPerUnit} m per pixel`);
    await close();
  });

  test('plans: a distance that is known is clicked when a plan is imported', async () => {
    const sheet = Buffer.from(await (await fetch(`${system.url}/v1/${(await planOf(system)).name}/files/sheet.png`)).arrayBuffer());
    const { page, close } = await open(browser(), at(`${SITE}/plans?import=1`));
    const form = page.getByRole('form', { name: 'Import a plan' });
    await form.getByLabel('File').setInputFiles([{ name: 'floor.png', mimeType: 'image/png', buffer: sheet }]);
    await form.getByLabel('Name').fill('Measured');
    await form.getByText('Give a known distance').click();
    const image = form.getByRole('img', { name: 'The imported plan' });
    await until('it is shown', () => image.evaluate(({ complete, naturalWidth }) => complete && naturalWidth > 0));
    const width = await image.evaluate(({ naturalWidth }) => naturalWidth);
    const shown = (await image.boundingBox()).width;
    await image.click({ position: { x: Math.round(0.25 * shown), y: 40 } });
    await form.getByRole('button', { name: 'Import', exact: true }).click();
    await form.getByRole('alert').filter({ hasText: 'second point' }).waitFor();
    await image.click({ position: { x: Math.round(0.75 * shown), y: 40 } });
    await form.getByLabel('Metres between the points').fill('12,5');
    await picture(page, 'plan-import-measure');
    assert.deepEqual(await faultsOf(page), []);
    await form.getByRole('button', { name: 'Import', exact: true }).click();
    await form.getByText('Imported:').waitFor();
    const { elements: { metresPerUnit } } = (await system.call(`sites/${SITE}/priorMaps`)).priorMaps.find(({ displayName }) => displayName === 'Measured');
    assert.ok(Math.abs(metresPerUnit / (12.5 / (width / 2)) - 1) < 0.01, `${metresPerUnit} m per pixel`);
    await close();
  });

  test('plans: before and after are faded into each other over the maps', async () => {
    const { name } = await planOf(system);
    await system.call(`${name}:align`, { fromLast: true });
    const plan = await planOf(system);
    assert.equal(plan.state, 'STATE_PROPOSED', plan.reason);
    const corrected = linesOf(await fileOf(system, 'walls.geojson'), 'wall');
    const [a, b, c, d, e, f] = plan.alignment.affineWorldSheet;
    const place = ({ x, y }) => ({ x: a * x + b * y + c, y: d * x + e * y + f });
    const placed = linesOf(await fileOf(system, 'plan.geojson'), 'wall').map(({ from, to }) => ({ from: place(from), to: place(to) }));
    // A wall that was moved, where the other picture has no wall.
    const moved = placed.map((wall, i) => ({ wall, to: corrected[i], by: distance(middle(wall), middle(corrected[i])) })).sort((x, y) => y.by - x.by)[0];
    const { page, close } = await open(browser(), at(`${SITE}/plans/${name.split('/').pop()}`));
    await page.getByRole('link', { name: 'Before and after' }).click();
    await until('the map is drawn', async () => (await drawnMaps(page)).length === 1);
    await settled(page);
    await picture(page, 'plan-after');
    const fade = page.getByRole('slider', { name: 'From before to after' });
    await look(page, { ...middle(moved.wall), scale: 60 });
    const isPlaced = async () => {
      const { at: pixel, width, height } = await pixelsOf(page);
      // Of the select colour, somewhere within three pixels.
      for (let dx = -3; dx <= 3; ++dx) for (let dy = -3; dy <= 3; ++dy) {
        const [red, green] = pixel(Math.round(width / 2) + dx, Math.round(height / 2) + dy);
        if (red > 150 && green < 100) return true;
      }
      return false;
    };
    assert.equal(await isPlaced(), false, 'after');
    await fade.focus();
    await page.keyboard.press('Home');
    await until('before', isPlaced);
    await page.getByRole('button', { name: 'Show after' }).click();
    await until('after', async () => !(await isPlaced()));
    await page.getByRole('button', { name: 'Show before' }).click();
    await until('before', isPlaced);
    await page.getByText(/^Walls were moved by/).waitFor();
    await page.locator('.scene-canvas').press('0');
    await fade.fill('0.5');
    await settled(page);
    await picture(page, 'plan-between');
    assert.deepEqual(await faultsOf(page), []);
    await close();
  });
}

// SPDX-License-Identifier: Apache-2.0
// Several people at one map, and what becomes of edits when something breaks.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { isDeepStrictEqual } from 'node:util';
import { faultsOf, launchToKill, open, picture } from '../browser.mjs';
import { drag, editedAt, editorAddress, editsOf, introduce, lookAt, newDraft, newMap, openEditor, publish, random, sameAsServer, screenOf, send, statsOf, stored } from '../editing.mjs';
import { until } from '../system.mjs';

const SITE = 'editing';
const [FREE, OCCUPIED] = [2, 3];

// What a browser says of a gateway that is away.
const away = { expected: /Failed to load resource|EventSource|ERR_/ };

export function addEditingTogether({ system, browser, at }) {
  test('two_editors: two browsers on one draft come to the same cells, whatever is cut, and each undoes its own', async () => {
    const draft = await newDraft(system, await newMap(system, 'two'));
    const [ann, bob] = [await openEditor(browser(), system, draft, 'Ann', away), await openEditor(browser(), system, draft, 'Bob', away)];
    const people = [[ann.page, random(1)], [bob.page, random(2)]];
    for (const [page] of people) await lookAt(page, 200, 200, 3);
    await ann.page.getByRole('region', { name: 'Also here' }).getByText('Bob').waitFor();
    for (let i = 0; i < 200; ++i) {
      for (const [page, next] of people) {
        if (i === 80) await page.context().setOffline(page === ann.page);
        if (i === 120) await page.context().setOffline(false);
        await page.keyboard.press(String(1 + next(4)));
        const from = [150 + next(100), 150 + next(100)];
        await drag(page, from, [from[0] + next(20) - 10, from[1] + next(20) - 10]);
      }
      if (i === 119) await ann.page.getByText(/not stored yet/).waitFor();
    }
    for (const [page] of people) await stored(page);
    const results = [];
    for (const [page] of people) results.push(await sameAsServer(page, system, draft));
    assert.deepEqual(results[0].own, results[0].server);
    assert.deepEqual(results[1].own, results[1].server);
    for (const key of Object.keys(results[0].own)) if (key in results[1].own) assert.equal(results[0].own[key], results[1].own[key], `tile ${key}`);
    const all = await editsOf(system, draft);
    assert.equal(all.length, 400);
    assert.deepEqual(['Ann', 'Bob'].map((name) => all.filter(({ author }) => author === name).length), [200, 200]);

    for (let i = 0; i < 5; ++i) await ann.page.keyboard.press('Control+z');
    await stored(ann.page);
    const off = (await editsOf(system, draft)).filter(({ active }) => !active);
    assert.equal(off.length, 5);
    assert.ok(off.every(({ author }) => author === 'Ann'), 'only one’s own');
    await ann.page.keyboard.press('Control+y');
    for (const [page] of people) {
      const { own, server } = await sameAsServer(page, system, draft);
      assert.deepEqual(own, server);
      assert.equal((await statsOf(page)).mismatches, 0);
    }
    await ann.close();
    await bob.close();
  });

  test('crash_restore: a browser that is killed in the middle of a stroke loses that stroke only', async (t) => {
    const draft = await newDraft(system, await newMap(system, 'crash'));
    const profile = join(system.folder, 'profile');
    const first = await launchToKill(profile);
    t.after(() => first.kill());
    await first.page.goto(editorAddress(system, draft));
    await introduce(first.page, 'Ann');
    await stored(first.page);
    await lookAt(first.page, 200, 200, 3);
    await first.page.keyboard.press('2');
    await drag(first.page, [100, 150], [120, 150]);
    await stored(first.page);
    await system.kill('gateway');
    await first.page.getByText(/Not live since/).waitFor();
    for (let i = 1; i <= 5; ++i) await drag(first.page, [100, 150 + 10 * i], [120, 150 + 10 * i]);
    await first.page.keyboard.press('Control+z');
    await first.page.getByText('6 edits not stored yet').waitFor();
    const { x, y } = await screenOf(first.page, 100, 250);
    await first.page.mouse.move(x, y);
    await first.page.mouse.down();
    await first.page.mouse.move(x + 50, y);
    assert.equal(await editedAt(first.page, 105, 250), OCCUPIED, 'it is seen on its way');
    await first.kill();

    await system.startGateway();
    await system.ready();
    const second = await launchToKill(profile);
    t.after(() => second.kill());
    await second.page.goto(editorAddress(system, draft));
    // A browser may forget the last seconds of what it keeps as settings, such as the name.
    await second.page.locator('.edit-canvas, .edit-author').first().waitFor();
    if (await second.page.locator('.edit-author').isVisible()) await introduce(second.page, 'Ann');
    await stored(second.page);
    const edits = await editsOf(system, draft);
    assert.deepEqual(edits.map(({ active = false }) => active), [true, true, true, true, true, false]);
    for (let i = 0; i <= 5; ++i) assert.equal(await editedAt(second.page, 110, 150 + 10 * i), i < 5 ? OCCUPIED : 0, `stroke ${i}`);
    assert.equal(await editedAt(second.page, 105, 250), 0);
    const { own, server } = await sameAsServer(second.page, system, draft);
    assert.deepEqual(own, server);
    // The stroke that was undone before can still be done again.
    await second.page.keyboard.press('Control+y');
    await stored(second.page);
    assert.equal(await editedAt(second.page, 110, 200), OCCUPIED);
  });

  test('crash_restore: edits survive a reload without the gateway, and are sent when it is back', async () => {
    const draft = await newDraft(system, await newMap(system, 'away'));
    const { page, close } = await openEditor(browser(), system, draft, 'Ann', away);
    await lookAt(page, 200, 200, 3);
    await page.keyboard.press('1');
    await system.kill('gateway');
    await drag(page, [100, 150], [120, 150]);
    await page.getByText(/1 edit not stored yet: .*Next attempt/).waitFor();
    await picture(page, 'editor-away');
    await system.startGateway();
    await system.ready();
    await stored(page);
    await page.getByText('All edits are stored').waitFor();
    assert.equal((await editsOf(system, draft)).length, 1);
    await close();
  });

  test('merge: drafts that say different things of no cell are both in', async () => {
    const map = await newMap(system, 'disjoint');
    const drafts = [await newDraft(system, map, 'left'), await newDraft(system, map, 'right')];
    for (const [i, draft] of drafts.entries()) {
      const { page, close } = await openEditor(browser(), system, draft, ['Ann', 'Bob'][i]);
      await lookAt(page, 200, 200, 3);
      await page.keyboard.press('2');
      await drag(page, [120 + 60 * i, 150], [140 + 60 * i, 150]);
      await stored(page);
      const dialog = await publish(page, `wall ${i}`);
      if (i === 1) await dialog.getByText('1 publication came since this draft began').waitFor();
      await send(dialog);
      await dialog.getByText('Published:').waitFor();
      if (i === 1) await dialog.getByText('put together with 1 publication').waitFor();
      await close();
    }
    const { page, close } = await openEditor(browser(), system, await newDraft(system, map), 'Ann');
    for (const column of [130, 190]) assert.equal(await editedAt(page, column, 150), OCCUPIED);
    await close();
  });

  test('merge: where two drafts differ a person chooses, by their names', async () => {
    const map = await newMap(system, 'overlap');
    const drafts = [await newDraft(system, map, 'one'), await newDraft(system, map, 'other')];
    const opened = [];
    for (const [i, draft] of drafts.entries()) {
      const one = await openEditor(browser(), system, draft, ['Ann', 'Bob'][i], { expected: /409|Failed to load resource/ });
      opened.push(one);
      await lookAt(one.page, 200, 200, 3);
      await one.page.keyboard.press(i === 0 ? '2' : '1');
      await one.page.keyboard.press('r');
      for (const column of [100, 180]) await drag(one.page, [column, 150], [column + 20, 170]);
      await stored(one.page);
    }
    const [ann, bob] = opened;
    const first = await publish(ann.page, 'occupied');
    await send(first);
    await first.getByText('Published:').waitFor();

    const second = await publish(bob.page, 'free');
    const conflicts = second.getByRole('region', { name: 'Conflicts' });
    const places = conflicts.getByRole('listitem');
    await until('both places are listed', async () => (await places.count()) === 2);
    assert.ok(await second.getByRole('button', { name: 'Publish', exact: true }).isDisabled());
    assert.deepEqual(await faultsOf(bob.page), []);
    await picture(bob.page, 'editor-conflicts');
    for (const place of await places.all()) {
      await place.getByLabel('This draft, by Bob').waitFor();
      await place.getByLabel('What is published, by Ann').waitFor();
    }
    // Mine on the left, theirs on the right, whichever is listed first.
    const isLeft = async (place) => / at 5\.\d/.test(await place.innerText());
    for (const place of await places.all()) await place.getByLabel((await isLeft(place)) ? 'This draft' : 'What is published').check();
    await conflicts.getByRole('button', { name: 'Settle the conflicts' }).click();
    await conflicts.waitFor({ state: 'detached' });
    await second.getByLabel('What was edited, and why').fill('free on the left');
    await send(second);
    await second.getByText('Published:').waitFor();
    const { page, close } = await openEditor(browser(), system, await newDraft(system, map), 'Ann');
    assert.equal(await editedAt(page, 110, 160), FREE, 'Bob’s');
    assert.equal(await editedAt(page, 190, 160), OCCUPIED, 'Ann’s');
    await close();
    for (const one of opened) await one.close();
  });

  test('merge: nothing is published from a stale draft, and an edit that comes too late is not lost', async () => {
    const map = await newMap(system, 'late');
    const draft = await newDraft(system, map);
    const [ann, bob] = [await openEditor(browser(), system, draft, 'Ann', away), await openEditor(browser(), system, draft, 'Bob', away)];
    for (const { page } of [ann, bob]) await lookAt(page, 200, 200, 3);
    await ann.page.keyboard.press('2');
    await drag(ann.page, [100, 150], [120, 150]);
    await stored(ann.page);
    const dialog = await publish(ann.page, 'a wall');
    await dialog.getByRole('button', { name: 'Check again' }).waitFor();
    await drag(bob.page, [100, 180], [120, 180]);
    await stored(bob.page);
    await send(dialog);
    await dialog.getByRole('alert').getByText(/Somebody else changed this/).waitFor();
    const stale = await fetch(`${system.url}/v1/${draft}:publish`, { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ etag: '1', message: 'late' }) });
    assert.equal(stale.status, 409, await stale.text());

    await bob.page.context().setOffline(true);
    await drag(bob.page, [100, 200], [120, 200]);
    await bob.page.getByText('1 edit not stored yet').waitFor();
    await dialog.getByRole('button', { name: 'Check again' }).click();
    await dialog.getByText(/cells become/).waitFor();
    await send(dialog);
    await dialog.getByText('Published:').waitFor();
    await bob.page.context().setOffline(false);
    await bob.page.getByText(/This draft takes no more edits: it is published. 1 edit of yours is not in it/).waitFor();
    await bob.page.getByRole('button', { name: 'Put them into a new draft' }).click();
    await bob.page.waitForURL((url) => !url.pathname.endsWith(draft.split('/').pop()));
    await stored(bob.page);
    assert.equal(await editedAt(bob.page, 110, 200), FREE);
    const { drafts } = await system.call(`${map}/drafts?state=STATE_OPEN`);
    assert.equal(drafts.length, 1);
    assert.equal((await editsOf(system, drafts[0].name)).length, 1);
    await ann.close();
    await bob.close();
  });

  test('contested: what robots see against an edit is listed, shown and settled', async () => {
    const site = 'contested';
    system.enfilade(site, 'site', 'create', site);
    const log = join(system.folder, 'rooms.jsonl');
    system.enfilade(site, '--quiet', 'simulate', '--laps', '1', '-o', log);
    const drive = (name, ...where) => system.enfilade(site, '--quiet', 'replay', log, '--map', 'Rooms', '--session', name, '--spool', join(system.folder, name), '--wait', ...where);
    drive('first');
    const map = (await system.call(`sites/${site}/maps`)).maps[0].name;
    const [, x, y, yaw] = /^[^\n]*\n([^,]*),([^,]*),([^,]*),([^,\n]*)/.exec(await (await fetch(`${system.url}/v1/sites/${site}/sessions/first/trajectory.csv`)).text()).slice(1).map(Number);
    // All walls are erased, and a robot that drives there again sees them.
    const draft = await newDraft(system, map, 'no walls');
    const { box } = await system.call(`${draft}:readTiles`, {});
    const [x0, y0] = [256 * (box.firstColumn ?? 0), 256 * (box.firstRow ?? 0)];
    const [x1, y1] = [x0 + 256 * box.width, y0 + 256 * box.height];
    const edit = {
      editId: '00000000-0000-4000-8000-000000000001', author: 'Ann', value: 'VALUE_FREE', onlyWhere: ['VALUE_OCCUPIED'],
      polygon: { rings: [{ points: [{ x: x0, y: y0 }, { x: x1, y: y0 }, { x: x1, y: y1 }, { x: x0, y: y1 }] }] },
    };
    await system.call(`${draft}:append`, { edits: [edit] });
    await system.call(`${draft}:publish`, { message: 'no walls here', confirmWarnings: true });
    drive('second', '--at', `${x},${y},${yaw}`);
    const contested = async () => (await system.call(`${map}/contestedEdits`)).contested ?? [];
    const count = (await contested()).length;
    assert.ok(count > 0, 'it is contested');

    const { page, close } = await openEditor(browser(), system, await newDraft(system, map), 'Bob');
    const inbox = page.getByRole('region', { name: 'Contested edits' });
    const item = inbox.getByRole('listitem').first();
    await item.getByText(/Ann made it free \(“no walls here”\); a robot saw it occupied since/).waitFor();
    assert.equal(await inbox.getByRole('listitem').count(), count);
    const before = await page.evaluate(() => window.__editor.camera());
    await item.getByRole('button', { name: 'Show', exact: true }).click();
    await until('it is jumped to', async () => !isDeepStrictEqual(await page.evaluate(() => window.__editor.camera()), before));
    await item.getByRole('button', { name: 'Keep the edit' }).click();
    if (count > 1) await inbox.getByRole('listitem').nth(1).getByRole('button', { name: 'Show what robots see' }).click();
    await inbox.getByLabel('Why').fill('looked at it');
    assert.deepEqual(await faultsOf(page), []);
    await picture(page, 'editor-contested');
    await page.keyboard.press('Enter');
    await inbox.getByText(/Settled: revision/).waitFor();
    const settled = Math.min(2, count);
    await until('they are off the list', async () => (await contested()).length === count - settled && (await inbox.getByRole('listitem').count()) === count - settled);
    const [{ source }] = (await system.call(`${map}/revisions`)).revisions;
    assert.equal(source, 'SOURCE_EDIT');
    await close();
  });
}

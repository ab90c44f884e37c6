// SPDX-License-Identifier: Apache-2.0
// Maps that are merged and split on the campus.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { drawnMaps, faultsOf, picture } from '../browser.mjs';
import { drag, editsOf, newDraft, openEditor, stored } from '../editing.mjs';
import { twoRooms } from '../maps.mjs';
import { until } from '../system.mjs';
import { edit, graphOf } from './graph_edit.mjs';

export function addRearranging(stage) {
  const { system, at } = stage;

  test('merge_maps: two maps are merged after a warning of what will happen, and it is undone', async () => {
    const site = 'merged';
    await twoRooms(system, site);
    const { page, close } = await edit(stage, site, 'maps/a');
    await page.getByLabel('With another map of its level').selectOption({ label: 'b' });
    await page.getByRole('button', { name: 'Merge …' }).click();
    const question = page.getByRole('group', { name: 'Merge “b” into “a”?' });
    await question.getByText('1 link point between the two goes.').waitFor();
    await picture(page, 'graph-merge');
    assert.deepEqual(await faultsOf(page), []);
    await question.getByRole('button', { name: 'Merge them' }).click();
    await until('there is one map', async () => (await graphOf(system, site)).maps.length === 1);
    const pin = page.getByLabel('Pinned: surveys leave it as it is');
    await until('the merged map is pinned', () => pin.isChecked());
    await pin.click();
    await until('it is given back to surveys', async () => !(await system.call(`sites/${site}/maps/a`)).map.pinned);
    await page.goto(at(`${site}/history/rearranged`));
    await page.getByRole('button', { name: /^Undo: b into a/ }).click();
    await page.getByRole('button', { name: 'Undo it' }).click();
    await until('there are two again, joined', async () => { const { maps, linkPoints } = await graphOf(system, site); return maps.length === 2 && linkPoints?.length === 1; });
    await page.getByText(/^undone /).waitFor();
    await close();
  });

  test('merge_maps: a draft goes on in the map that stays', async () => {
    const site = 'merged-draft';
    await twoRooms(system, site);
    const draft = await newDraft(system, `sites/${site}/maps/b`, 'Glass');
    const { page, close } = await openEditor(stage.browser(), system, draft, 'Ann', { expected: /404|Failed to load resource|EventSource/ });
    await page.keyboard.press('2');
    const { box } = await system.call(`${draft}:readTiles`, {});
    const column = (box.firstColumn ?? 0) + Math.floor(box.width / 2);
    const row = (box.firstRow ?? 0) + Math.floor(box.height / 2);
    await drag(page, [column, row], [column + 10, row]);
    await stored(page);
    await system.call(`sites/${site}/maps/a:merge`, { mergedMap: `sites/${site}/maps/b` });
    await page.getByText('The draft goes on there.').waitFor();
    await page.getByRole('alert').getByRole('link').click();
    await page.getByRole('link', { name: 'Glass' }).click();
    await stored(page);
    assert.equal((await editsOf(system, draft.replace('/maps/b/', '/maps/a/'))).length, 1);
    await close();
  });

  test('split_map: a session gets a map of its own, then a part of one, and it is undone', async () => {
    const site = 'split';
    system.enfilade(site, 'site', 'create', site);
    const log = join(system.folder, 'split.jsonl');
    system.enfilade(site, '--quiet', 'simulate', '--laps', '1', '-o', log);
    const drive = (robot, ...where) => system.enfilade(site, '--quiet', 'replay', log, '--map', 'Rooms', '--robot', robot, '--session', robot, '--spool', join(system.folder, `split-${robot}`), '--wait', ...where);
    drive('r1');
    const start = (await (await fetch(`${system.url}/v1/sites/${site}/sessions/r1/trajectory.csv`)).text()).split('\n')[1].split(',').slice(1);
    drive('r2', '--at', start.join(','));
    const rooms = (await system.call(`sites/${site}/maps`)).maps[0].name;
    const before = (await system.call(rooms)).map;
    const { page, close } = await edit(stage, site, rooms.split('/').slice(2).join('/'), {}, 1);
    const split = async () => {
      await page.getByRole('button', { name: 'Split …' }).click();
      return page.getByRole('group', { name: 'Split “Rooms”?' });
    };
    const mapOf = async (session) => (await system.call(`sites/${site}/sessions/${session}`)).session.map;
    const undo = async (what) => {
      await page.goto(at(`${site}/history/rearranged`));
      await page.getByRole('button', { name: what }).click();
      await page.getByRole('button', { name: 'Undo it' }).click();
      await until('there is one map again', async () => (await graphOf(system, site)).maps.length === 1);
      await page.getByText(/^undone /).first().waitFor();
    };

    const question = await split();
    await question.getByText('Choose at least one session that leaves.').waitFor();
    assert.ok(await question.getByRole('button', { name: 'Split it' }).isDisabled());
    const row = (robot) => question.getByRole('listitem').filter({ hasText: `${robot}, ` });
    for (const robot of ['r1', 'r2']) await row(robot).getByRole('combobox').selectOption('leaves');
    await question.getByText('One session must stay, or nothing is divided.').waitFor();
    await row('r1').getByRole('combobox').selectOption('stays');
    await question.getByText('1 session leaves “Rooms” for a new map.').waitFor();
    assert.deepEqual(await faultsOf(page), []);
    await picture(page, 'graph-split');
    await question.getByRole('button', { name: 'Split it' }).click();
    await until('two maps are drawn', async () => (await drawnMaps(page)).length === 2);
    await question.waitFor({ state: 'detached' });
    await picture(page, 'graph-split-done');
    const { maps, linkPoints } = await graphOf(system, site);
    assert.deepEqual([maps.length, linkPoints.length], [2, 1], 'an opening joins them');
    assert.equal(await mapOf('r1'), rooms);
    assert.notEqual(await mapOf('r2'), rooms);
    assert.ok(page.url().includes((await mapOf('r2')).split('/').pop()), 'the new one is selected');
    await undo(/^Undo: new: /);
    assert.equal(await mapOf('r2'), rooms);
    assert.deepEqual((await system.call(before.latestRevision)).revision.contentSha256, (await system.call((await system.call(rooms)).map.latestRevision)).revision.contentSha256, 'the map is as it was');

    // The rest of a session from a record on.
    await page.goto(at(`${site}/campus?edit=graph&sel=${encodeURIComponent(rooms.split('/').slice(2).join('/'))}`));
    const again = await split();
    const second = again.getByRole('listitem').filter({ hasText: 'r2, ' });
    await second.getByRole('combobox').selectOption('cut');
    await again.getByText('The rest of 1 session does so as a session of its own.').waitFor();
    await again.getByRole('button', { name: 'Split it' }).click();
    await until('two maps are drawn', async () => (await drawnMaps(page)).length === 2);
    const { sessions } = await system.call(`sites/${site}/sessions`);
    assert.deepEqual([sessions.length, sessions.filter(({ map }) => map === rooms).length], [3, 2]);
    await undo(/^Undo: new: .* cut$/);
    assert.equal((await system.call(`sites/${site}/sessions`)).sessions.length, 2);
    await close();
  });
}

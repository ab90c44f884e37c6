// SPDX-License-Identifier: Apache-2.0
// Who sees little, or uses no pointer, can edit maps: what axe says of each state of the editor, in both themes.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultsOf, open, picture, settled } from '../browser.mjs';
import { drag, editorAddress, introduce, lookAt, newDraft, newMap, publish, send, stored } from '../editing.mjs';

const SITE = 'editing';

export function addEditorAccess({ system, browser, at }) {
  test('a11y: axe finds nothing serious in the editor, its forms and dialogs, and in the versions of a map, in either theme', async () => {
    const map = await newMap(system, 'a11y');
    const corners = [{ x: 6, y: 6 }, { x: 10, y: 6 }, { x: 8, y: 10 }];
    await system.call(`${map}/areas`, { displayName: 'Stairs', kind: 'KIND_KEEP_OUT', outline: { corners }, robotTypes: ['tug'] });
    for (const theme of ['light', 'dark']) {
      const { page, close } = await open(browser(), editorAddress(system, await newDraft(system, map, theme)), { theme });
      const check = async (what) => {
        assert.deepEqual(await faultsOf(page), [], `${what}, ${theme}`);
        await picture(page, `a11y-${what.replaceAll(' ', '-')}-${theme}`);
      };
      await page.getByRole('textbox', { name: 'Your name' }).waitFor();
      await check('asked for the name');
      await introduce(page, 'Ann');
      await stored(page);
      await lookAt(page, 200, 200, 3);
      await page.keyboard.press('2');
      await drag(page, [100, 150], [140, theme === 'light' ? 150 : 170]);
      await stored(page);
      await page.getByText('Draw by numbers', { exact: true }).click();
      await check('editor');
      const areas = page.getByRole('region', { name: 'Areas' });
      await areas.getByRole('button', { name: /^Stairs/ }).click();
      await areas.getByRole('button', { name: 'Delete', exact: true }).click();
      await check('question');
      await areas.getByRole('button', { name: 'Keep it' }).click();
      await areas.getByRole('button', { name: 'Edit', exact: true }).click();
      const form = page.getByRole('form', { name: 'Edit Stairs' });
      await form.getByLabel('Name').fill('');
      await form.getByLabel('Kind').selectOption('Speed limit');
      await form.getByRole('button', { name: 'Save' }).click();
      await form.getByRole('alert').waitFor();
      await check('area');
      await form.getByRole('button', { name: 'Cancel' }).click();
      const dialog = await publish(page, 'a wall');
      await dialog.getByText(/become/).first().waitFor();
      await check('publish');
      await send(dialog);
      await dialog.getByText('Published:').waitFor();
      await check('published');
      for (const [what, path] of [['map', ''], ['versions', '?rev=1'], ['difference', '?rev=2&with=1'], ['drafts', '/edit']]) {
        await page.goto(at(`${SITE}/maps/a11y${path}`));
        await settled(page);
        await check(what);
      }
      await close();
    }
  });
}

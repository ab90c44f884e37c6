// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultsOf, open, picture } from './browser.mjs';
import { setStage } from './stage.mjs';
import { until } from './system.mjs';

const { system, browser } = setStage();

test('docs: the reference lists every operation, opens one, and loads nothing from elsewhere', async () => {
  const document = await (await fetch(`${system.url}/openapi.json`)).json();
  const operations = Object.values(document.paths).flatMap((item) => Object.values(item).filter(({ operationId }) => operationId));
  assert.ok(operations.every(({ tags }) => tags.length === 1));
  for (const theme of ['light', 'dark']) {
    const asked = [];
    const { page, close } = await open(browser(), 'about:blank', { theme });
    page.on('request', (request) => asked.push(new URL(request.url()).origin));
    await page.goto(`${system.url}/docs`);
    await page.locator('.opblock-tag').first().waitFor();
    // One at a time: when many operations are open, Swagger UI renders only those in sight.
    const listed = page.locator('.opblock');
    for (const { name } of document.tags) {
      const count = operations.filter(({ tags }) => tags.includes(name)).length;
      await page.locator(`#operations-tag-${name}`).click();
      await until(`all ${count} operations of ${name} are listed`, async () => (await listed.count()) === count);
      await page.locator(`#operations-tag-${name}`).click();
      await listed.first().waitFor({ state: 'detached' });
    }
    await page.locator('#operations-tag-SiteService').click();
    await page.locator('#operations-SiteService-ListSites button.opblock-summary-control').click();
    await page.getByText('From the previous answer; empty for the first page.').waitFor();
    await picture(page, `docs-${theme}`);
    await page.evaluate(() => scrollTo(0, 0));
    await picture(page, `docs-top-${theme}`);
    assert.deepEqual([...new Set(asked)], [system.url]);
    // Swagger UI puts an operation's link into the button that opens it.
    assert.deepEqual((await faultsOf(page)).filter((fault) => !fault.startsWith('nested-interactive')), []);
    await close();
  }
});

test('docs: a call can be tried', async () => {
  system.enfilade('tried', 'site', 'create', 'tried', '--name', 'Tried');
  const { page, close } = await open(browser(), `${system.url}/docs#/SiteService/ListSites`);
  await page.getByRole('button', { name: 'Try it out' }).click();
  await page.getByRole('button', { name: 'Execute' }).click();
  await page.locator('.live-responses-table').getByText('sites/tried').first().waitFor();
  await close();
});

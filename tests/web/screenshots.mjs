// SPDX-License-Identifier: Apache-2.0
// Writes the pictures of README.md and docs/web.md, and beside them what the pages consisted of.
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { launch, open } from './browser.mjs';
import { mapCampus } from './campus.mjs';
import { folder, picturesOf, root, show, standing, structureOf, structuresFile, viewport } from './pictures.mjs';
import { System } from './system.mjs';

const system = new System();
let browser;
try {
  await system.start();
  await mapCampus(system);
  const pictures = await picturesOf(system);
  const stand = await standing(system, ['r1', 'r2']);
  browser = await launch();
  mkdirSync(join(root, folder), { recursive: true });
  const { page, close } = await open(browser, system.url, viewport);
  const structures = {};
  for (const [name, picture] of Object.entries(pictures)) {
    await show(page, picture);
    structures[name] = await structureOf(page);
    await page.screenshot({ path: join(root, folder, `${name}.png`) });
    console.log(`${folder}/${name}.png`);
  }
  await close();
  stand();
  writeFileSync(structuresFile, `${JSON.stringify(structures, null, 1)}\n`);
} finally {
  await browser?.close();
  await system.stop();
}

// SPDX-License-Identifier: Apache-2.0
// Writes the pictures of README.md and docs/web.md, and beside them what the pages consisted of.
import { existsSync, mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { launch, open } from './browser.mjs';
import { mapCampus } from './campus.mjs';
import { folder, picturesOf, root, show, standing, storedStructures, structureOf, structuresFile, viewport } from './pictures.mjs';
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
  const names = process.argv.slice(2);
  const fileOf = (name) => join(root, folder, `${name}.png`);
  const isWanted = (name) => names.length === 0 || names.includes(name) || !existsSync(fileOf(name));
  const stored = existsSync(structuresFile) ? storedStructures() : {};
  const structures = {};
  for (const [name, picture] of Object.entries(pictures)) {
    if (!isWanted(name)) {
      structures[name] = stored[name];
      continue;
    }
    await show(page, picture);
    structures[name] = await structureOf(page);
    await page.screenshot({ path: fileOf(name) });
    console.log(`${folder}/${name}.png`);
  }
  await close();
  stand();
  writeFileSync(structuresFile, `${JSON.stringify(structures, null, 1)}\n`);
} finally {
  await browser?.close();
  await system.stop();
}

// SPDX-License-Identifier: Apache-2.0
import { after, afterEach, before } from 'node:test';
import { closeWhatIsLeft, launch } from './browser.mjs';
import { System } from './system.mjs';

// A system and a browser for the tests of a file, from before its first one until after its last one. `prepare`: what is
// done with the system before the first test. (Hooks of one file do not wait for each other.) Pages that a test leaves open
// are closed when it ends.
export function setStage(prepare = () => {}) {
  const system = new System();
  let browser;
  before(async () => {
    await system.start();
    browser = await launch();
    await prepare(system);
  });
  afterEach(closeWhatIsLeft);
  after(async () => {
    await browser?.close();
    await system.stop();
  });
  return { system, browser: () => browser };
}

// SPDX-License-Identifier: Apache-2.0
// Pages in a real Chromium. A message on the console, an exception or a breach of the Content-Security-Policy fails the test.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { until } from './system.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

export const launch = (options = []) =>
  chromium.launch({
    executablePath: process.env.ENFILADE_CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--enable-unsafe-swiftshader', ...options],
  });

// A browser with a profile of its own, which a test may kill as a power cut would. One at a time for each profile.
export async function launchToKill(profile) {
  const port = join(profile, 'DevToolsActivePort');
  rmSync(port, { force: true });
  const child = spawn(process.env.ENFILADE_CHROMIUM ?? '/usr/bin/chromium',
    ['--headless=new', '--no-sandbox', '--no-first-run', '--enable-unsafe-swiftshader', '--remote-debugging-port=0', `--user-data-dir=${profile}`, 'about:blank'],
    // It removes its temporary files only if it may end.
    { stdio: 'ignore', env: { ...process.env, TMPDIR: profile } });
  const ended = new Promise((resolve) => child.once('exit', resolve));
  const [number, path] = (await until('the browser listens', () => existsSync(port) && readFileSync(port, 'utf8').includes('/') && readFileSync(port, 'utf8'))).trim().split('\n');
  const browser = await chromium.connectOverCDP(`ws://127.0.0.1:${number}${path}`);
  const page = await browser.contexts()[0].newPage();
  await page.setViewportSize({ width: 1280, height: 800 });
  return {
    page,
    // Also a second time.
    async kill() {
      child.kill('SIGKILL');
      await ended;
      await browser.close().catch(() => {});
    },
  };
}

// Chromium's software renderer says this of every screenshot.
const ofTheRenderer = /GL Driver Message \(OpenGL, Performance/;

// For what a page does, ms: on a busy machine it takes long.
const patience = 120_000;

// What a test has opened and not closed, because it failed.
const leftOpen = new Set();

// Closes it: a page that goes on reading makes later tests fail, too.
export async function closeWhatIsLeft() {
  for (const context of leftOpen) await context.close().catch(() => {}); // its browser may be gone
  leftOpen.clear();
}

// Opens a page in a context of its own. `expected`: what the console may say besides, for tests that stop the server.
export async function open(browser, url, { theme = 'light', width = 1280, height = 800, expected = /^$/ } = {}) {
  const context = await browser.newContext({ colorScheme: theme, viewport: { width, height }, reducedMotion: 'reduce' });
  context.setDefaultTimeout(patience);
  leftOpen.add(context);
  const page = await context.newPage();
  const problems = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !expected.test(message.text()) && !ofTheRenderer.test(message.text())) problems.push(message.text());
  });
  page.on('pageerror', (error) => problems.push(String(error)));
  await page.addInitScript(() => {
    window.breaches = [];
    addEventListener('securitypolicyviolation', (event) => window.breaches.push(`${event.violatedDirective} ${event.blockedURI}`));
  });
  await page.goto(url);
  return {
    page,
    // Ends the page and says what went wrong in it.
    async close() {
      const breaches = await page.evaluate(() => window.breaches);
      await context.close();
      leftOpen.delete(context);
      assert.deepEqual(problems, [], 'the console is empty');
      assert.deepEqual(breaches, [], 'nothing breaks the Content-Security-Policy');
    },
  };
}

// Waits until the page loads nothing more, and the map shows all that it can show.
export async function settled(page) {
  await page.locator('main').getByText(/./).first().waitFor();
  await page.waitForFunction(() => {
    if (document.querySelector('[role=status][aria-label=Loading]')) return false;
    return !document.querySelector('.scene-canvas') || window.__scene.settled();
  });
}

// Serious faults of accessibility, by axe. It is put in by the debugger, which no policy of the page hinders.
export async function faultsOf(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run({ resultTypes: ['violations'] }));
  return violations
    .filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target.join(' ')).join(', ')}`);
}

export const drawnMaps = (page) => page.evaluate(() => (window.__scene?.drawn() ?? []).filter(({ kind }) => kind === 'map'));

// A picture in $ENFILADE_SCREENSHOTS, if that is set.
export async function picture(page, name) {
  const folder = process.env.ENFILADE_SCREENSHOTS;
  if (!folder) return;
  mkdirSync(folder, { recursive: true });
  await page.screenshot({ path: join(folder, `${name}.png`) });
}

// SPDX-License-Identifier: Apache-2.0
// What a large campus takes is counted; how long it takes is told, and measured by `bench`. ENFILADE_MAPS=1000: as many as the
// dashboard is made for.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { dragged, drawCalls, firstCampus } from './bench_page.mjs';
import { driveAround, fill } from './bench_site.mjs';
import { open, settled } from './browser.mjs';
import { look } from './pixels.mjs';
import { setStage } from './stage.mjs';
import { until } from './system.mjs';

const maps = Number(process.env.ENFILADE_MAPS ?? 60);
const [linkPoints, robots] = [2 * maps, maps / 2];
const { system, browser } = setStage();

test('scale: a campus needs at most 12 requests to be shown, and 6 draw calls a frame', async (t) => {
  await fill(system, maps, linkPoints);
  const fleet = await driveAround(system, robots, maps);
  t.after(() => fleet.stop());
  const { page, close } = await open(browser(), 'about:blank');
  const { requests, requested, first_campus_ms } = await firstCampus(page, `${system.url}/s/bench/campus`, maps);
  assert.ok(requests <= 12, `${requests} requests: ${requested.join(' ')}`);
  await until('all robots are drawn', () => page.evaluate((n) => window.__scene.drawn().filter(({ kind }) => kind === 'robot').length === n, robots));
  const { frames, scripts, long_tasks, longest_task_ms } = await dragged(page);
  t.diagnostic(`${maps} maps, ${robots} robots: first campus ${first_campus_ms} ms with ${requests} requests; ${frames} frames while dragged, scripts p50 ${scripts.p50_ms} ms, ` +
    `p95 ${scripts.p95_ms} ms; ${long_tasks} tasks of more than 50 ms, the longest ${longest_task_ms} ms`);
  const { scale: least } = await page.evaluate(() => window.__scene.camera());
  for (let scale = least; scale < 100; scale *= 3) {
    await look(page, { x: 6.4, y: 6.4, scale }); // in the first room
    const calls = await drawCalls(page);
    assert.ok(calls >= 1 && calls <= 6, `${calls} draw calls at ${scale} pixels per metre`);
  }
  await settled(page);
  assert.equal(fleet.refused(), 0, 'all reports are taken');
  await close();
});

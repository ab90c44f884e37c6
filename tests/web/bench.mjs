// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how long the dashboard takes to show a campus of many maps, and how long its scripts take for a frame.
// usage: ENFILADE_BIN=DIR node bench.mjs [MAPS]. Robots are not part of it: they report by gRPC.
import { launch } from './browser.mjs';
import { System } from './system.mjs';

const COLUMNS = 32;
const SIDE = 256; // cells of a map
const CELL_M = 0.05;
const EDGE_M = SIDE * CELL_M;
const count = Number(process.argv[2] ?? 1000);

// A room with walls around and small obstacles, different in each map.
function pgm(seed) {
  const cells = Buffer.alloc(SIDE * SIDE, 254);
  const wall = (x, y) => (cells[y * SIDE + x] = 0);
  for (let i = 0; i < SIDE; ++i) [[i, 0], [i, SIDE - 1], [0, i], [SIDE - 1, i]].forEach(([x, y]) => wall(x, y));
  for (let n = 0; n < 40; ++n) {
    const [x, y] = [10 + ((seed * 7919 + n * 104729) % 230), 10 + ((seed * 31 + n * 7907) % 230)];
    for (let i = 0; i < 24; ++i) wall(x + (i % 8), y + Math.floor(i / 8));
  }
  return Buffer.concat([Buffer.from(`P5\n${SIDE} ${SIDE}\n255\n`), cells]);
}

const yaml = `image: m.pgm\nresolution: ${CELL_M}\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n`;
const at = (map, x, y) => ({ map: `sites/bench/maps/m${map}`, poseMapPlace: { pose: { x, y, yaw: 0 }, covariance: [0.0015, 0, 0, 0, 0.0015, 0, 0, 0, 0.00002] } });

// `make(i)` for all i below n, some at a time.
async function forAll(n, make) {
  let next = 0;
  const work = async () => { while (next < n) await make(next++); };
  await Promise.all(Array.from({ length: 4 }, work));
}

async function fill(system) {
  system.enfilade('bench', 'site', 'create', 'bench');
  await forAll(count, async (i) => {
    await system.call(`sites/bench/maps?mapId=m${i}`, { displayName: `Room ${i}` });
    const form = new FormData();
    form.append('file', new Blob([yaml]), 'm.yaml');
    form.append('file', new Blob([pgm(i)]), 'm.pgm');
    const answer = await fetch(`${system.url}/v1/sites/bench/maps/m${i}:import`, { method: 'POST', body: form });
    if (!answer.ok) throw new Error(await answer.text());
  });
  const doors = [];
  for (let i = 0; i < count; ++i) {
    if (i % COLUMNS > 0) doors.push([at(i - 1, EDGE_M, EDGE_M / 2), at(i, 0, EDGE_M / 2)]);
    if (i >= COLUMNS) doors.push([at(i - COLUMNS, EDGE_M / 2, EDGE_M), at(i, EDGE_M / 2, 0)]);
  }
  await forAll(doors.length, (i) => system.call('sites/bench/linkPoints', { kind: 'KIND_DOOR', anchors: doors[i] }));
  await system.call('sites/bench:optimize', {});
}

const quantile = (values, share) => [...values].sort((a, b) => a - b)[Math.floor(values.length * share)];

async function show(browser, url) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  let requests = 0;
  page.on('request', () => ++requests);
  const begin = Date.now();
  await page.goto(`${url}/s/bench/campus`);
  await page.waitForFunction((n) => window.__scene?.drawn().filter(({ kind }) => kind === 'map').length >= n, count, { timeout: 300_000 });
  const shown = { first_campus_ms: Date.now() - begin, requests };
  await page.waitForTimeout(3000);
  await page.evaluate(() => (window.__scene.stats().frameMs.length = 0));
  await page.mouse.move(500, 400);
  await page.mouse.down();
  for (let i = 0; i < 60; ++i) await page.mouse.move(500 + 3 * (i % 30), 400 + 2 * i);
  await page.mouse.up();
  const { frameMs, drawCalls } = await page.evaluate(() => window.__scene.stats());
  await page.close();
  return { ...shown, draw_calls: drawCalls, pan: { frames: frameMs.length, p50_ms: quantile(frameMs, 0.5), p95_ms: quantile(frameMs, 0.95) } };
}

const system = new System();
let browser;
try {
  await system.start();
  await fill(system);
  browser = await launch();
  const cold = await show(browser, system.url); // the server makes the pictures of all maps
  const warm = [];
  for (let i = 0; i < 3; ++i) warm.push(await show(browser, system.url));
  console.log(JSON.stringify({ benchmark: 'dashboard', maps: count, cold, warm }, null, 2));
} finally {
  await browser?.close();
  await system.stop();
}

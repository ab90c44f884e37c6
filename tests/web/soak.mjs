// SPDX-License-Identifier: Apache-2.0
// Prints JSON: what a tab that shows a campus of busy robots takes over time, and what the gateway takes.
// usage: ENFILADE_BIN=DIR node soak.mjs MINUTES [ROBOTS] [PLOT.svg]
// Fails if something grows by more than 5 % after the first sixth of the time, or if the console says something.
import { readFileSync, writeFileSync } from 'node:fs';
import { launch, open } from './browser.mjs';
import { plot } from './plot.mjs';
import { Robots } from './robots.mjs';
import { System, until } from './system.mjs';

const minutes = Number(process.argv[2]);
const count = Number(process.argv[3] ?? 500);
const samples = 60;
const hz = 2;
const allowed = 1.05;

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
const residentMib = (pid) => Number(/VmRSS:\s*(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

// Robots drive in circles, in the maps in turn.
async function drive(system, maps) {
  const robots = new Robots(system, 'demo');
  const all = Array.from({ length: count }, (_, i) => ({ id: `soak${i}`, map: maps[i % maps.length], phase: i }));
  for (const { id, map } of all) await robots.begin(id, map);
  let reports = 0;
  const timer = setInterval(() => {
    const time = Date.now() / 4000;
    for (const { id, map, phase } of all) {
      const angle = time + phase;
      robots.report(id, map, { x: 1 + Math.cos(angle), y: 1 + Math.sin(angle), yaw: angle });
      ++reports;
    }
  }, 1000 / hz);
  return { robots, reports: () => reports, stop: () => (clearInterval(timer), robots.close()) };
}

// What is held now: the heap after a collection.
async function sample(page, debug, system) {
  await debug.send('HeapProfiler.collectGarbage');
  const { usedSize } = await debug.send('Runtime.getHeapUsage');
  const { nodes } = await debug.send('Memory.getDOMCounters');
  const { tiles, frames, tileRequests } = await page.evaluate(() => window.__scene.stats());
  return { heap_mib: usedSize / 2 ** 20, dom_nodes: nodes, tiles, tile_requests: tileRequests, frames,
    gateway_mib: residentMib(system.gateway.pid), server_mib: residentMib(system.server.pid) };
}

// By how much the end is above the time after the beginning: medians of a sixth each.
function growth(rows, name) {
  const part = Math.max(1, Math.floor(rows.length / 6));
  const values = rows.map((row) => row[name]);
  return median(values.slice(-part)) / median(values.slice(part, 2 * part));
}

async function watch(page, debug, system, driving) {
  const rows = [];
  const begin = Date.now();
  for (let i = 0; i < samples; ++i) {
    await pause(begin + ((i + 1) * minutes * 60_000) / samples - Date.now());
    rows.push({ minute: (Date.now() - begin) / 60_000, reports: driving.reports(), ...(await sample(page, debug, system)) });
    console.error(JSON.stringify(rows.at(-1)));
  }
  return rows;
}

// Why answers of the gateway did not reach the page whole, as its log says.
function cutAnswers(system) {
  return system.log('gateway.log').split('\n').filter((line) => line.includes('"cut":')).map((line) => JSON.parse(line));
}

async function soak(system, browser) {
  system.enfilade('demo', 'site', 'create', 'demo', '--name', 'Soak');
  await system.drive('demo', 'r1', '--campus', 'figure1', '--rate', '20', '--map', 'Hall');
  const { maps } = await system.call('sites/demo/maps');
  const driving = await drive(system, maps.map(({ name }) => name.split('/').at(-1)));
  const { page, close } = await open(browser, `${system.url}/s/demo/campus`);
  try {
    await until('all robots are drawn', () => page.evaluate((n) => (window.__scene?.drawn() ?? []).filter(({ kind }) => kind === 'robot').length >= n, count));
    const rows = await watch(page, await page.context().newCDPSession(page), system, driving);
    const said = await close().then(() => '', ({ message }) => message);
    const growths = Object.fromEntries(['heap_mib', 'tiles', 'dom_nodes', 'gateway_mib'].map((name) => [name, growth(rows, name)]));
    return { benchmark: 'soak', minutes, robots: count, hz, refused: driving.robots.refused.length, said, cut: cutAnswers(system),
      growth: growths, rows };
  } finally {
    driving.stop();
  }
}

const system = new System();
let browser;
try {
  await system.start();
  browser = await launch();
  const result = await soak(system, browser);
  console.log(JSON.stringify(result, null, 1));
  if (process.argv[4]) writeFileSync(process.argv[4], plot(result.rows));
  const grown = Object.entries(result.growth).filter(([, ratio]) => !(ratio < allowed));
  if (grown.length > 0 || result.refused > 0 || result.said !== '') {
    console.error(`FAILED: ${grown.map(([name, ratio]) => `${name} grew by ${((ratio - 1) * 100).toFixed(1)} %`)} ${result.refused} refused ${result.said}`);
    process.exitCode = 1;
  }
} finally {
  await browser?.close();
  await system.stop();
}

// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how long the dashboard takes to show a large campus, and how long its scripts take for a frame.
// usage: ENFILADE_BIN=DIR node bench.mjs [MAPS [LINK_POINTS [ROBOTS]]]
import { measure } from './bench_page.mjs';
import { driveAround, fill } from './bench_site.mjs';
import { launch } from './browser.mjs';
import { System } from './system.mjs';

const [maps = 1000, linkPoints = 2000, robots = 500] = process.argv.slice(2).map(Number);
const system = new System();
let browser;
let fleet;
try {
  await system.start();
  await fill(system, maps, linkPoints);
  browser = await launch();
  const url = `${system.url}/s/bench/campus`;
  const cold = await measure(browser, url, maps); // the server makes the pictures of all maps
  fleet = await driveAround(system, robots, maps);
  const warm = [];
  const begin = { time: Date.now(), reports: fleet.reports() };
  for (let i = 0; i < 3; ++i) warm.push(await measure(browser, url, maps));
  const reports_per_second = Math.round((1000 * (fleet.reports() - begin.reports)) / (Date.now() - begin.time));
  const profiled = await measure(browser, url, maps, true);
  console.log(JSON.stringify({ benchmark: 'dashboard', maps, link_points: linkPoints, robots, reports_per_second, refused: fleet.refused(), cold, warm, profiled }, null, 2));
} finally {
  fleet?.stop();
  await browser?.close();
  await system.stop();
}

// SPDX-License-Identifier: Apache-2.0
// A site as large as those that the dashboard is made for.
import { Robots } from './robots.mjs';

const COLUMNS = 32;
const SIDE = 256; // cells of a map
const CELL_M = 0.05;
const EDGE_M = SIDE * CELL_M;

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

// Fills the site `bench` with `count` maps in rows, a door between each two neighbours, and candidates up to `linkPoints`.
export async function fill(system, count, linkPoints) {
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
  for (let i = 0; doors.length < linkPoints; ++i) doors.push([at(i % count, 3 + Math.floor(i / count), 5)]);
  await forAll(doors.length, (i) => system.call('sites/bench/linkPoints', { kind: 'KIND_DOOR', anchors: doors[i] }));
  await system.call('sites/bench:optimize', {});
}

// Robots that drive in circles, each in a map of its own, and report twice a second until the returned function is called.
export async function driveAround(system, robots, maps) {
  const fleet = new Robots(system, 'bench');
  const mapOf = (i) => `m${Math.floor((i * maps) / robots)}`;
  await forAll(robots, (i) => fleet.begin(`r${i}`, mapOf(i)));
  let reports = 0;
  const report = (i) => {
    const angle = 0.4 * i + Date.now() / 5000;
    fleet.report(`r${i}`, mapOf(i), { x: 6.4 + 3 * Math.cos(angle), y: 6.4 + 3 * Math.sin(angle), yaw: angle + Math.PI / 2 }, [0.02, 0.005, 0, 0.005, 0.01, 0, 0, 0, 0.001]);
    ++reports;
  };
  // A fiftieth of them each 10 ms, as robots do not report all at once.
  let next = 0;
  const timer = setInterval(() => {
    for (const end = next + robots / 50; next < end; ++next) report(next % robots);
  }, 10);
  return {
    reports: () => reports,
    refused: () => fleet.refused.length,
    stop() {
      clearInterval(timer);
      fleet.close();
    },
  };
}

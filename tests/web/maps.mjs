// SPDX-License-Identifier: Apache-2.0
// Maps that tests draw themselves, and maps as files.
export const CELL_M = 0.05;

// A PGM; occupied(x, y) counts cells from the lower left corner.
export function pgmOf(width, height, occupied) {
  const cells = Buffer.alloc(width * height, 254);
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) if (occupied(x, y)) cells[(height - 1 - y) * width + x] = 0;
  return Buffer.concat([Buffer.from(`P5\n${width} ${height}\n255\n`), cells]);
}

// Makes a map of it. `origin`: the lower left corner in the map's frame.
export async function importMap(system, site, id, pgm, displayName = id, origin = { x: 0, y: 0 }) {
  await system.call(`sites/${site}/maps?mapId=${id}`, { displayName });
  const form = new FormData();
  form.append('file', new Blob([`image: m.pgm\nresolution: ${CELL_M}\norigin: [${origin.x}, ${origin.y}, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n`]), 'm.yaml');
  form.append('file', new Blob([pgm]), 'm.pgm');
  const answer = await fetch(`${system.url}/v1/sites/${site}/maps/${id}:import`, { method: 'POST', body: form });
  if (!answer.ok) throw new Error(await answer.text());
}

// A link point's place in a map.
export const anchor = (site, map, { x = 0, y = 0, yaw = 0 }) => ({
  map: `sites/${site}/maps/${map}`, poseMapPlace: { pose: { x, y, yaw }, covariance: [0.0015, 0, 0, 0, 0.0015, 0, 0, 0, 0.00002] },
});

// The walls of a building in metres: its rooms differ, so that it fits onto itself at one place only.
const building = {
  width: 16, height: 8,
  walls: [[0, 0, 16, 0], [16, 0, 16, 8], [16, 8, 0, 8], [0, 8, 0, 0], [4, 0, 4, 5], [4, 5, 6.5, 5], [7, 8, 7, 6.2], [9, 0, 9, 3.4], [9, 3.4, 12.5, 3.4], [11, 8, 11, 5.5], [13.5, 3, 13.5, 6.7], [6, 2, 7.2, 2], [7.2, 2, 7.2, 1]],
};
// A corridor without ends looks the same wherever one stands in it.
const corridor = { width: 24, height: 3, walls: [[0, 0, 24, 0], [0, 3, 24, 3]] };

const offWall = ([x0, y0, x1, y1], { x, y }) => {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const t = Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)));
  return Math.hypot(x - x0 - t * dx, y - y0 - t * dy);
};

const SPAN_M = 32;
const corner = { x: -14, y: -16 };

// Imports what a robot sees of it between two x, in a frame of its own: `pose` is that of the frame in the building's.
async function importPart(system, site, id, { width, height, walls }, pose, [from, to]) {
  const cells = SPAN_M / CELL_M;
  const pgm = Buffer.alloc(cells * cells, 128); // neither free nor occupied
  const [cos, sin] = [Math.cos(pose.yaw), Math.sin(pose.yaw)];
  for (let row = 0; row < cells; ++row) {
    for (let column = 0; column < cells; ++column) {
      const [x, y] = [corner.x + (column + 0.5) * CELL_M, corner.y + (row + 0.5) * CELL_M];
      const place = { x: pose.x + cos * x - sin * y, y: pose.y + sin * x + cos * y };
      if (place.x < Math.max(from, -CELL_M) || place.x > Math.min(to, width + CELL_M) || place.y < -CELL_M || place.y > height + CELL_M) continue;
      pgm[(cells - 1 - row) * cells + column] = walls.some((wall) => offWall(wall, place) < CELL_M) ? 0 : 254;
    }
  }
  await importMap(system, site, id, Buffer.concat([Buffer.from(`P5\n${cells} ${cells}\n255\n`), pgm]), id, corner);
}

// Maps a and b of one building that overlap in its middle third; `pose`: of b in a.
export async function overlapping(system, site, pose) {
  system.enfilade(site, 'site', 'create', site);
  await importPart(system, site, 'a', building, { x: 0, y: 0, yaw: 0 }, [-1, 11]);
  await importPart(system, site, 'b', building, pose, [5, 17]);
}

// Maps a and b of one corridor.
export async function corridors(system, site) {
  system.enfilade(site, 'site', 'create', site);
  await importPart(system, site, 'a', corridor, { x: 0, y: 0, yaw: 0 }, [2, 16]);
  await importPart(system, site, 'b', corridor, { x: 6, y: 0, yaw: 0 }, [8, 22]);
}

// Where the door of two rooms is in room b.
const doorInB = { x: 0, y: 5, yaw: -0.5 };

// A site of two rooms of 10 m x 10 m with walls around, a and b, joined by a door: b is turned.
export async function twoRooms(system, site) {
  const room = pgmOf(200, 200, (x, y) => x === 0 || y === 0 || x === 199 || y === 199);
  system.enfilade(site, 'site', 'create', site);
  for (const map of ['a', 'b']) await importMap(system, site, map, room);
  await system.call(`sites/${site}/linkPoints?linkPointId=door`, { kind: 'KIND_DOOR', anchors: [anchor(site, 'a', { x: 10, y: 5 }), anchor(site, 'b', doorInB)] });
  await system.call(`sites/${site}:optimize`, {});
}

// The same with three doors that agree with one another.
export async function threeDoors(system, site) {
  await twoRooms(system, site);
  const turn = { cos: Math.cos(doorInB.yaw), sin: Math.sin(doorInB.yaw) };
  for (const [id, along] of [['south', -3.5], ['north', 3.5]]) {
    const inB = { x: doorInB.x - turn.sin * along, y: doorInB.y + turn.cos * along, yaw: doorInB.yaw };
    await system.call(`sites/${site}/linkPoints?linkPointId=${id}&force=true`, { kind: 'KIND_DOOR', anchors: [anchor(site, 'a', { x: 10, y: 5 + along }), anchor(site, 'b', inB)] });
  }
  await system.call(`sites/${site}:optimize`, {});
}

// Moves the door of two rooms to another place in room a, and with it room b.
export async function moveDoor(system, site, inA) {
  const name = `sites/${site}/linkPoints/door`;
  const { linkPoint } = await system.call(name);
  const anchors = [anchor(site, 'a', inA), anchor(site, 'b', doorInB)];
  const answer = await fetch(`${system.url}/v1/${name}?updateMask=anchors`, { method: 'PATCH', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ ...linkPoint, anchors }) });
  if (!answer.ok) throw new Error(await answer.text());
  await system.call(`sites/${site}:optimize`, {});
}

// A map's newest revision as Nav2 would read it: walls by column and row from the lower left corner.
export async function downloaded(system, map) {
  const { files } = await (await fetch(`${system.url}/v1/${map}/files?format=pgm`)).json();
  const fetched = async (suffix) => Buffer.from(await (await fetch(`${system.url}${files.find(({ name }) => name.endsWith(suffix)).path}`)).arrayBuffer());
  const yaml = (await fetched('.yaml')).toString();
  const pgm = await fetched('.pgm');
  const [head, width, height] = /^P5\s+(\d+)\s+(\d+)\s+\d+\s/.exec(pgm.subarray(0, 64).toString('latin1'));
  const cells = pgm.subarray(head.length);
  const [x, y, yaw] = /origin: *\[([^\]]*)\]/.exec(yaml)[1].split(',').map(Number);
  const resolution = Number(/resolution: *(\S+)/.exec(yaml)[1]);
  const [columns, rows] = [Number(width), Number(height)];
  const inside = (column, row) => column >= 0 && row >= 0 && column < columns && row < rows;
  const wall = (column, row) => inside(column, row) && cells[(rows - 1 - row) * columns + column] < 89; // occupied_thresh 0.65
  return { columns, rows, resolution, origin: { x, y, yaw }, wall };
}

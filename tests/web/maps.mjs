// SPDX-License-Identifier: Apache-2.0
// Maps that tests draw themselves, and maps as files.
export const CELL_M = 0.05;

// A PGM; occupied(x, y) counts cells from the lower left corner.
export function pgmOf(width, height, occupied) {
  const cells = Buffer.alloc(width * height, 254);
  for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) if (occupied(x, y)) cells[(height - 1 - y) * width + x] = 0;
  return Buffer.concat([Buffer.from(`P5\n${width} ${height}\n255\n`), cells]);
}

// Makes a map of it, whose origin is the lower left corner.
export async function importMap(system, site, id, pgm, displayName = id) {
  await system.call(`sites/${site}/maps?mapId=${id}`, { displayName });
  const form = new FormData();
  form.append('file', new Blob([`image: m.pgm\nresolution: ${CELL_M}\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n`]), 'm.yaml');
  form.append('file', new Blob([pgm]), 'm.pgm');
  const answer = await fetch(`${system.url}/v1/sites/${site}/maps/${id}:import`, { method: 'POST', body: form });
  if (!answer.ok) throw new Error(await answer.text());
}

// A link point's place in a map.
export const anchor = (site, map, { x = 0, y = 0, yaw = 0 }) => ({
  map: `sites/${site}/maps/${map}`, poseMapPlace: { pose: { x, y, yaw }, covariance: [0.0015, 0, 0, 0, 0.0015, 0, 0, 0, 0.00002] },
});

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

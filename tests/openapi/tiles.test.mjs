// SPDX-License-Identifier: Apache-2.0
// Vector tiles, read by Mapbox's own library, have everything where the server's projection has it.
import { VectorTile } from '@mapbox/vector-tile';
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { PbfReader } from 'pbf';
import { System } from '../web/system.mjs';

let system;
const zoom = 22; // a unit of a tile is 2.3 mm at the equator

const get = (path) => fetch(path.startsWith('http') ? path : `${system.url}/v1/${path}`);

// Of Web Mercator: the tile that has a place.
function tileAt([longitude, latitude], z) {
  const y = Math.asinh(Math.tan((latitude * Math.PI) / 180));
  return { z, x: Math.floor(((longitude + 180) / 360) * 2 ** z), y: Math.floor(((1 - y / Math.PI) / 2) * 2 ** z) };
}

async function read(template, { z, x, y }) {
  const answer = await get(template.replace('{z}', z).replace('{x}', x).replace('{y}', y));
  assert.equal(answer.status, 200);
  assert.equal(answer.headers.get('content-type'), 'application/vnd.mapbox-vector-tile');
  assert.match(answer.headers.get('cache-control'), /immutable/);
  const tile = new VectorTile(new PbfReader(new Uint8Array(await answer.arrayBuffer())));
  const features = (layer) =>
    layer ? Array.from({ length: layer.length }, (_, i) => layer.feature(i).toGeoJSON(x, y, z)) : [];
  return Object.fromEntries(['link_points', 'outlines', 'tracks'].map((name) => [name, features(tile.layers[name])]));
}

// Metres between places that are close together.
function metres([longitudeA, latitudeA], [longitudeB, latitudeB]) {
  const east = (longitudeB - longitudeA) * Math.cos((latitudeA * Math.PI) / 180);
  return Math.hypot(east, latitudeB - latitudeA) * ((6_378_137 * Math.PI) / 180);
}

// From a place to the nearest of the vertices, metres.
const nearest = (place, vertices) => Math.min(...vertices.map((vertex) => metres(place, vertex)));

async function prepare() {
  await system.start();
  const log = join(system.folder, 'drive.jsonl');
  system.enfilade('tiles', 'simulate', '-o', log, '--laps', '1');
  system.enfilade('tiles', 'site', 'create', 'tiles');
  const corners = [[-1, -1], [20, -1], [20, 9], [-1, 12]].map(([x, y]) => ({ x, y }));
  await system.call('sites/tiles/maps?mapId=rooms', { displayName: 'Rooms', outline: { corners } });
  system.enfilade('tiles', 'replay', log, '--map', 'Rooms', '--session', 'drive', '--spool', join(system.folder, 'spool'), '--wait');
  await addLinkPoint('door', 3);
}

const addLinkPoint = (id, x) =>
  system.call(`sites/tiles/linkPoints?linkPointId=${id}`,
    { kind: 'KIND_LIFT', anchors: [{ map: 'sites/tiles/maps/rooms', poseMapPlace: { pose: { x, y: 1.5 } } }] });

async function georeference() {
  const point = (x, y) => ({ map: 'sites/tiles/maps/rooms', x, y, latitude: 49.0069 + y / 111_300, longitude: 8.4037 + x / 73_200 });
  const answer = await fetch(`${system.url}/v1/sites/tiles/georeference`, { method: 'PUT', headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify({ controlPoints: [point(0, 0), point(30, 0), point(0, 30)] }) });
  assert.equal(answer.status, 200, await answer.text());
}

test('mvt: tiles of a version have link points, outlines and tracks within 1 cm', async (t) => {
  system = new System();
  t.after(() => system.stop());
  await prepare();
  assert.equal((await get('sites/tiles/mvt.json')).status, 404, 'without a georeference there are no tiles');
  await georeference();
  const { tiles: [template], bounds, version } = await (await get('sites/tiles/mvt.json')).json();
  const wanted = await (await get('sites/tiles/graph.geojson?edges=false&tracks=true')).json();
  const of = (kind) => wanted.features.find(({ properties }) => properties.kind === kind);
  assert.equal(`${wanted.graph_version}.0.0`, version);

  const door = of('link_point_candidate').geometry.coordinates;
  const { link_points } = await read(template, tileAt(door, zoom));
  assert.deepEqual(link_points.map(({ properties }) => [properties.link_point, properties.passage, properties.maps]), [['door', 'lift', 'rooms']]);
  assert.ok(metres(link_points[0].geometry.coordinates, door) < 0.01, `${metres(link_points[0].geometry.coordinates, door)} m`);

  for (const [layer, vertices] of [['outlines', of('map').geometry.coordinates[0]], ['tracks', of('track').geometry.coordinates]]) {
    for (const vertex of [vertices[0], vertices[Math.floor(vertices.length / 2)]]) {
      const [feature] = (await read(template, tileAt(vertex, zoom)))[layer];
      const away = nearest(vertex, feature.geometry.coordinates.flat(feature.geometry.type.startsWith('Multi') || layer === 'outlines' ? 1 : 0));
      assert.ok(away < 0.01, `${layer}: ${away} m`);
    }
  }

  const centre = [(bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2];
  const whole = await read(template, tileAt(centre, 15));
  assert.deepEqual(Object.values(whole).map(({ length }) => length), [1, 1, 1], 'one of each is in a tile of all');
  const elsewhere = await read(template, { z: 3, x: 0, y: 0 });
  assert.deepEqual(Object.values(elsewhere).map(({ length }) => length), [0, 0, 0]);

  await addLinkPoint('second', 4);
  const { tiles: [next] } = await (await get('sites/tiles/mvt.json')).json();
  assert.notEqual(next, template);
  assert.equal((await read(next, tileAt(centre, 15))).link_points.length, 2);
  assert.equal((await read(template, tileAt(centre, 15))).link_points.length, 1, 'a version stays as it was');

  for (const [path, status] of [['999999/1/0/0.mvt', 404], ['1/2/4/0.mvt', 400], ['1/25/0/0.mvt', 400], ['x/1/0/0.mvt', 400], ['1/1/0/0.png', 400]]) {
    assert.equal((await get(`sites/tiles/mvt/${path}`)).status, status, path);
  }
});

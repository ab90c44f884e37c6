// SPDX-License-Identifier: Apache-2.0
// Whatever is called by the document, valid or not, the answer is no fault of the server and as the document says.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { test } from 'node:test';
import { System } from '../web/system.mjs';

let system;
const here = import.meta.dirname;

// Two sites with a map that a robot has mapped.
async function prepare() {
  await system.start();
  const log = join(system.folder, 'drive.jsonl');
  system.enfilade('fuzz', 'simulate', '-o', log, '--laps', '1');
  for (const site of ['fuzz', 'doomed']) {
    system.enfilade(site, 'site', 'create', site);
    await system.call(`sites/${site}/maps?mapId=rooms`, { displayName: 'Rooms' });
    system.enfilade(site, 'replay', log, '--map', 'Rooms', '--session', 'drive', '--spool', join(system.folder, `${site}.spool`), '--wait');
  }
}

const idsOf = async (collection, field = collection) =>
  (await system.call(`sites/fuzz/${collection}`))[field].map(({ name }) => name.split('/').at(-1));

// The ids of what there is, by the name of the document's path parameter.
async function names() {
  const revisions = await idsOf('maps/rooms/revisions', 'revisions');
  const manifest = await system.call(`sites/fuzz/maps/rooms/revisions/${revisions[0]}/manifest`);
  const tiles = manifest.levels.flatMap(({ tiles }) => tiles.map(({ sha256 }) => Buffer.from(sha256, 'base64').toString('hex')));
  const anchor = { map: 'sites/fuzz/maps/rooms', poseMapPlace: { pose: { x: 1 } } };
  await system.call('sites/fuzz/linkPoints?linkPointId=door', { kind: 'KIND_DOOR', anchors: [anchor] });
  const { graphVersions } = await system.call('sites/fuzz/graphVersions');
  const versions = graphVersions.map(({ graphVersion }) => graphVersion);
  return { graphVersion: versions, site: ['fuzz'], map: ['rooms'], revision: revisions, session: ['drive'], robot: await idsOf('robots'), linkPoint: ['door'], sha256: tiles };
}

const ended = (child) => new Promise((resolve, reject) => child.once('exit', resolve).once('error', reject));

test('openapi: fuzz: no call is answered by a fault of the server', async (t) => {
  system = new System();
  t.after(() => system.stop());
  await prepare();
  const report = process.env.ENFILADE_OUT ? resolve(process.env.ENFILADE_OUT) : system.folder;
  mkdirSync(report, { recursive: true });
  const child = spawn(join(here, 'schemathesis'), ['run', `${system.url}/openapi.json`,
    '--checks', 'not_a_server_error,content_type_conformance,response_schema_conformance',
    '--max-examples', process.env.ENFILADE_EXAMPLES ?? '10', '--seed', process.env.ENFILADE_SEED ?? '1',
    '--phases', 'coverage,fuzzing', '--workers', '2', '--generation-database', 'none', '--no-color', '--warnings', 'off',
    // Streams do not end: gateway/tests has them.
    '--exclude-path-regex', ':watch$', '--request-timeout', '60', '--suppress-health-check', 'all', '--continue-on-failure',
    '--report', 'json', '--report-json-path', join(report, 'openapi.json')],
  { cwd: system.folder, stdio: 'inherit',
    env: { ...process.env, SCHEMATHESIS_HOOKS: join(here, 'hooks.py'), ENFILADE_NAMES: JSON.stringify(await names()) } });
  assert.equal(await ended(child), 0);
  assert.ok(system.serverRuns());
  await system.ready();
});

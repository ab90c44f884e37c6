// SPDX-License-Identifier: Apache-2.0
// A client that openapi-typescript generates from the gateway's document has right types, and works.
import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { test } from 'node:test';
import openapiTS, { astToString } from 'openapi-typescript';
import { System } from '../web/system.mjs';

test('openapi: a generated client passes its type check and does what it says', async (t) => {
  const system = new System();
  t.after(() => system.stop());
  await system.start();
  mkdirSync('out', { recursive: true });
  writeFileSync('out/openapi.ts', astToString(await openapiTS(new URL(`${system.url}/openapi.json`))));
  execFileSync('node', ['node_modules/typescript/bin/tsc', '-p', '.'], { stdio: 'inherit' });
  const { scenario } = await import('./out/scenario.js');
  await scenario(system.url);
});

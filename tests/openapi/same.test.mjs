// SPDX-License-Identifier: Apache-2.0
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';

test('openapi: every RPC answers over REST as by gRPC, errors included', (t) => {
  t.diagnostic(execFileSync('./same_answers', [process.env.ENFILADE_BIN]).toString().trim());
});

// SPDX-License-Identifier: Apache-2.0
// The campus of `make demo`: two robots map it together.
import { until } from './system.mjs';

// r2 starts in r1's first map as soon as that exists, 1.4 m behind r1 and 0.5 m to its left.
export async function mapCampus(system) {
  system.enfilade('demo', 'site', 'create', 'demo', '--name', 'Simulated campus');
  const campus = ['--campus', 'figure1', '--rate', '20'];
  const first = system.drive('demo', 'r1', ...campus, '--map', 'Hall');
  const follow = async () => {
    await until('r1 has begun its first map', async () => ((await system.call('sites/demo/maps')).maps ?? []).some(({ displayName }) => displayName === 'Hall'));
    await system.drive('demo', 'r2', ...campus, '--on-existing-map', 'Hall,-1.44,0.51,1.686', '--seed', '2');
  };
  await Promise.all([first, follow()]);
}

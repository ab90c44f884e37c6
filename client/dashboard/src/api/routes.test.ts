// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import routes from '../gen/routes.json';
import { callOf } from './routes';

const call = (method: string, message: Parameters<typeof callOf>[2]) =>
  callOf(method, (routes as Record<string, Parameters<typeof callOf>[1]>)[`enfilade.v1.${method}`], message);

test('puts names into the path and scalars into the query', () => {
  expect(call('MapService.ListMaps', { parent: 'sites/demo', pageSize: 5, displayName: 'Hall & yard' })).toEqual({
    verb: 'GET', url: '/v1/sites/demo/maps?pageSize=5&displayName=Hall+%26+yard',
  });
});

test('repeats lists and joins nested fields with dots', () => {
  expect(call('WatchService.WatchSite', { parent: 'sites/demo', levels: [0, -1] }).url).toBe('/v1/sites/demo:watch?levels=0&levels=-1');
});

test('takes the field that is the body, and leaves the rest in the query', () => {
  expect(call('MapService.UpdateMap', { map: { name: 'sites/s/maps/m', level: 2 }, updateMask: 'level' })).toEqual({
    verb: 'PATCH', url: '/v1/sites/s/maps/m?updateMask=level', body: '{"level":2}',
  });
});

test('takes all that is not in the path for the body "*"', () => {
  expect(call('LinkPointService.FindLinkPoints', { parent: 'sites/s', level: 1 })).toEqual({
    verb: 'POST', url: '/v1/sites/s/linkPoints:find', body: '{"level":1}',
  });
});

test('chooses the binding that the message fills', () => {
  expect(call('GraphService.GetGlobalPose', { robot: 'sites/s/robots/r1' }).url).toBe('/v1/sites/s/robots/r1/globalPose');
  expect(call('GraphService.GetGlobalPose', { mapPose: { map: 'sites/s/maps/m' } })).toEqual({
    verb: 'POST', url: '/v1/globalPose:get', body: '{"mapPose":{"map":"sites/s/maps/m"}}',
  });
  expect(call('MapService.ExportMap', { name: 'sites/s/maps/m/revisions/3' }).url).toBe('/v1/sites/s/maps/m/revisions/3:export');
});

test('refuses a name of another kind, and names that would leave their place', () => {
  expect(() => call('MapService.GetMap', { name: 'sites/s/robots/r' })).toThrow(/no address/);
  expect(() => call('MapService.GetMap', { name: 'sites//maps/m' })).toThrow(/no address/);
  expect(call('MapService.GetMap', { name: 'sites/s/maps/a?b' }).url).toBe('/v1/sites/s/maps/a%3Fb');
});

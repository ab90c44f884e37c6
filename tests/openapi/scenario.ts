// SPDX-License-Identifier: Apache-2.0
// What a program in TypeScript does with the API, by a client that was generated from /openapi.json alone.
import createClient from 'openapi-fetch';
import type { paths } from './out/openapi.js';

function check(holds: boolean, what: string): asserts holds {
  if (!holds) throw new Error(what);
}

// Runs on a site of its own at the gateway; throws if an answer is not as it should be.
export async function scenario(baseUrl: string): Promise<void> {
  const api = createClient<paths>({ baseUrl });
  const site = 'openapi';
  const path = { site };

  const made = await api.POST('/v1/sites', { params: { query: { siteId: site } }, body: { displayName: 'By a generated client' } });
  check(made.data?.site?.name === `sites/${site}`, `CreateSite: ${JSON.stringify(made)}`);

  for (const mapId of ['hall', 'yard']) {
    const map = await api.POST('/v1/sites/{site}/maps', { params: { path, query: { mapId } }, body: { displayName: mapId, level: 1 } });
    check(map.data?.map?.level === 1 && typeof map.data.map.etag === 'string', `CreateMap: ${JSON.stringify(map)}`);
  }

  const anchor = (map: string, x: number) => ({ map: `sites/${site}/maps/${map}`, poseMapPlace: { pose: { x } } });
  const door = await api.POST('/v1/sites/{site}/linkPoints', {
    params: { path, query: { linkPointId: 'door' } },
    body: { kind: 'KIND_DOOR', anchors: [anchor('hall', 5), anchor('yard', 0.5)] },
  });
  check(door.data?.linkPoint?.anchors?.length === 2, `CreateLinkPoint: ${JSON.stringify(door)}`);

  const pose = await api.POST('/v1/globalPose:get', {
    body: { mapPose: { map: `sites/${site}/maps/yard`, poseMapRobot: { pose: { x: 1 } } } },
  });
  const world = pose.data?.globalPose?.poseWorldRobot?.pose;
  check(Math.abs((world?.x ?? 0) - 5.5) < 1e-6, `GetGlobalPose: ${JSON.stringify(pose)}`);
  check(typeof pose.data?.globalPose?.graphVersion === 'string', 'a 64-bit integer is a text');

  const near = await api.POST('/v1/sites/{site}/linkPoints:find', { params: { path }, body: { pointWorld: { x: 5 } } });
  check(near.data?.found?.[0]?.linkPoint?.name === `sites/${site}/linkPoints/door`, `FindLinkPoints: ${JSON.stringify(near)}`);

  const changed = await api.PATCH('/v1/sites/{site}/linkPoints/{linkPoint}', {
    params: { path: { site, linkPoint: 'door' }, query: { updateMask: 'tag' } },
    body: { tag: 'North door' },
  });
  check(changed.data?.linkPoint?.tag === 'North door', `UpdateLinkPoint: ${JSON.stringify(changed)}`);

  const names: string[] = [];
  for (let pageToken = ''; ; ) {
    const page = await api.GET('/v1/sites/{site}/maps', { params: { path, query: { pageSize: 1, pageToken } } });
    check(page.data?.maps?.length === 1, `ListMaps: ${JSON.stringify(page)}`);
    names.push(...page.data.maps.map(({ name }) => name ?? ''));
    if (!(pageToken = page.data.nextPageToken ?? '')) break;
  }
  check(names.join() === `sites/${site}/maps/hall,sites/${site}/maps/yard`, `ListMaps: ${names}`);

  const nowhere = await api.GET('/v1/sites/{site}/maps/{map}', { params: { path: { site, map: 'nowhere' } } });
  check(nowhere.response.status === 404 && nowhere.error?.code === 5 && !!nowhere.error.message, `GetMap: ${JSON.stringify(nowhere.error)}`);
  const again = await api.POST('/v1/sites', { params: { query: { siteId: site } }, body: { displayName: 'Another' } });
  check(again.response.status === 409 && again.error?.code === 6, `CreateSite again: ${JSON.stringify(again.error)}`);
  // @ts-expect-error: the document says that a name is a text
  const wrong = await api.POST('/v1/sites', { params: {}, body: { displayName: 7 } });
  check(wrong.response.status === 400, `CreateSite with a number: ${wrong.response.status}`);

  const deleted = await api.DELETE('/v1/sites/{site}', { params: { path, query: { force: true } } });
  check(deleted.response.status === 200, `DeleteSite: ${JSON.stringify(deleted.error)}`);
  const maps = await api.GET('/v1/sites/{site}/maps', { params: { path } });
  // FAILED_PRECONDITION while it is being deleted, then NOT_FOUND.
  check(maps.error?.code === 9 || maps.error?.code === 5, `ListMaps of a deleted site: ${JSON.stringify(maps)}`);
}

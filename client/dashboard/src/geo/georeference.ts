// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { Code, ConnectError } from '@connectrpc/connect';
import { graphs, sites } from '../api/clients';
import { siteName } from '../api/names';
import { GraphVersion_Cause, type ControlPoint, type Georeference } from '../gen/enfilade/v1/graph_pb';
import { AuditEntry_Action } from '../gen/enfilade/v1/site_service_pb';
import type { LiveSite } from '../live/site';
import { affineOf, apply } from '../scene/affine';
import type { Point, Pose } from '../scene/camera';
import { fromPlane, toPlane, type LatLon } from './wgs84';

// False if the history shows that nobody has ever set one.
async function wasSet(site: string): Promise<boolean> {
  const { graphVersions, nextPageToken } = await graphs.listGraphVersions({ parent: siteName(site), pageSize: 1000 });
  const isWhole = nextPageToken === '' && (graphVersions.at(-1)?.graphVersion ?? 1n) === 1n;
  return !isWhole || graphVersions.some(({ cause }) => cause === GraphVersion_Cause.GEOREFERENCED);
}

// True if the audit trail shows that all control points have been deleted.
async function wasRemoved(site: string): Promise<boolean> {
  const { entries } = await sites.listAuditEntries({ parent: siteName(site), resource: `${siteName(site)}/controlPoints`, pageSize: 1000 });
  const last = new Map<string, AuditEntry_Action>();
  for (const { resource, action } of entries) if (!last.has(resource)) last.set(resource, action);
  return last.size > 0 && [...last.values()].every((action) => action === AuditEntry_Action.DELETED);
}

// Browsers write each answer 404 to the console as an error: where there surely is none, none is asked for.
const mayHaveOne = async (site: string) => (await wasSet(site)) && !(await wasRemoved(site));

// Null: the site has none. Fitted anew by the server when the graph changes.
export function useGeoreference(site: LiveSite) {
  return useQuery({
    queryKey: ['georeference', site.id, String(site.graphVersion)],
    placeholderData: (earlier: Georeference | null | undefined) => earlier,
    queryFn: async () => {
      if (!(await mayHaveOne(site.id))) return null;
      try {
        return (await graphs.getGeoreference({ site: siteName(site.id) })).georeference ?? null;
      } catch (error) {
        if (ConnectError.from(error).code === Code.NotFound) return null;
        throw error;
      }
    },
  });
}

type Place = Pick<ControlPoint, 'map' | 'x' | 'y'>;

// Of a place in a map; undefined while that map has no place in the world.
export function inWorld(site: LiveSite, { map, x, y }: Place): Point | undefined {
  const pose: Pose | undefined = site.maps.get(map)?.poseWorldMap?.pose;
  return pose && apply(affineOf(pose), { x, y });
}

const mean = (points: Point[]): Point => ({
  x: points.reduce((sum, { x }) => sum + x, 0) / points.length, y: points.reduce((sum, { y }) => sum + y, 0) / points.length,
});

// From the world to latitude and longitude. The server's fit turns about the centre of the control points and tells the
// direction; the centres are on one another.
export function toLatLon(controls: { world: Point; place: LatLon }[], yawEastWorld: number): (world: Point) => LatLon {
  const origin = controls[0]!.place;
  const ground = mean(controls.map(({ place }) => toPlane(origin, place)));
  const world = mean(controls.map((control) => control.world));
  const [cos, sin] = [Math.cos(yawEastWorld), Math.sin(yawEastWorld)];
  return ({ x, y }) => {
    const [dx, dy] = [x - world.x, y - world.y];
    return fromPlane(origin, { x: ground.x + cos * dx - sin * dy, y: ground.y + sin * dx + cos * dy });
  };
}

// Undefined if the site has no georeference, or a control point's map has no place.
export function converterOf(site: LiveSite, georeference: Georeference | null | undefined): ((world: Point) => LatLon) | undefined {
  if (!georeference || georeference.controlPoints.length < 2) return undefined;
  const controls = georeference.controlPoints.flatMap((point) => {
    const world = inWorld(site, point);
    return world ? [{ world, place: point }] : [];
  });
  return controls.length === georeference.controlPoints.length ? toLatLon(controls, georeference.yawEastWorld) : undefined;
}

// 1e-7 degrees are a centimetre.
export const latLonText = ({ latitude, longitude }: LatLon) => `${latitude.toFixed(7)}, ${longitude.toFixed(7)}`;

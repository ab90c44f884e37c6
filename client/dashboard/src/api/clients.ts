// SPDX-License-Identifier: Apache-2.0
import { createClient } from '@connectrpc/connect';
import { GraphService } from '../gen/enfilade/v1/graph_service_pb';
import { LinkPointService } from '../gen/enfilade/v1/link_point_service_pb';
import { MapAreaService } from '../gen/enfilade/v1/map_area_service_pb';
import { MapEditService } from '../gen/enfilade/v1/map_edit_service_pb';
import { MapService } from '../gen/enfilade/v1/map_service_pb';
import { PriorMapService } from '../gen/enfilade/v1/prior_map_service_pb';
import { RasterService } from '../gen/enfilade/v1/raster_service_pb';
import { RobotService } from '../gen/enfilade/v1/robot_service_pb';
import { ServerService } from '../gen/enfilade/v1/server_service_pb';
import { SessionService } from '../gen/enfilade/v1/session_service_pb';
import { SiteService } from '../gen/enfilade/v1/site_service_pb';
import routes from '../gen/routes.json';
import { createRestTransport } from './transport';
import { readOwnWrites } from './versions';

const transport = createRestTransport(routes, readOwnWrites((url, init) => fetch(url, init)));

export const graphs = createClient(GraphService, transport);
export const linkPoints = createClient(LinkPointService, transport);
export const mapAreas = createClient(MapAreaService, transport);
export const mapEdits = createClient(MapEditService, transport);
export const maps = createClient(MapService, transport);
export const priorMaps = createClient(PriorMapService, transport);
export const rasters = createClient(RasterService, transport);
export const robots = createClient(RobotService, transport);
export const server = createClient(ServerService, transport);
export const sessions = createClient(SessionService, transport);
export const sites = createClient(SiteService, transport);

// All items of a List, page by page; `page` makes the call.
export async function collect<T>(page: (pageToken: string) => Promise<[items: T[], nextPageToken: string]>): Promise<T[]> {
  const all: T[] = [];
  let token = '';
  do {
    const [items, next] = await page(token);
    all.push(...items);
    token = next;
  } while (token !== '');
  return all;
}

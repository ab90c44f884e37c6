// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { MapArea_Kind, MapAreaSchema } from '../../gen/enfilade/v1/map_area_pb';
import { boundsOfCorners } from '../../scene/areas';
import { areaShown, areaText } from './areas';

test('says what an area means, for whom and until when', () => {
  const ramp = create(MapAreaSchema, { kind: MapArea_Kind.SPEED_LIMIT, speedLimitMps: 0.3, robotTypes: ['cleaner', 'forklift'], validUntil: { seconds: 1767225600n } });
  expect(areaText(ramp)).toMatch(/^Speed limit 0\.3 m\/s, for cleaner, forklift, until .*20(25|26)/);
  expect(areaText(create(MapAreaSchema, { kind: MapArea_Kind.KEEP_OUT }))).toBe('Keep-out');
});

test('is drawn by what robots may do there', () => {
  const corners = [{ x: 1, y: 5 }, { x: -2, y: 0 }, { x: 0, y: 7 }];
  const shown = areaShown(create(MapAreaSchema, { name: 'sites/s/maps/m/areas/a', kind: MapArea_Kind.KEEP_OUT, outline: { corners } }));
  expect(shown).toEqual({ name: 'sites/s/maps/m/areas/a', tone: 'closed', corners });
  expect(areaShown(create(MapAreaSchema, { kind: MapArea_Kind.ROOM })).tone).toBe('other');
  expect(boundsOfCorners(shown.corners)).toEqual({ minX: -2, minY: 0, maxX: 1, maxY: 7 });
});

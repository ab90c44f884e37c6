// SPDX-License-Identifier: Apache-2.0
import { timestampMs, type Timestamp } from '@bufbuild/protobuf/wkt';
import { MapArea_Kind, type MapArea } from '../../gen/enfilade/v1/map_area_pb';
import type { Area, AreaTone } from '../../scene/areas';
import { dateTime } from '../../ui/format';

const kinds: Record<MapArea_Kind, string> = {
  [MapArea_Kind.UNSPECIFIED]: 'Area',
  [MapArea_Kind.KEEP_OUT]: 'Keep-out',
  [MapArea_Kind.SPEED_LIMIT]: 'Speed limit',
  [MapArea_Kind.PREFERRED]: 'Preferred',
  [MapArea_Kind.IGNORE_HITS]: 'Ignored hits',
  [MapArea_Kind.ROOM]: 'Room',
  [MapArea_Kind.DOCK]: 'Dock',
};

const tones: Partial<Record<MapArea_Kind, AreaTone>> = { [MapArea_Kind.KEEP_OUT]: 'closed', [MapArea_Kind.SPEED_LIMIT]: 'slow' };

const at = (time: Timestamp) => dateTime(timestampMs(time));

// What an area says, in a line: "Speed limit 0.3 m/s, for forklift, until ...".
export function areaText({ kind, speedLimitMps, robotTypes, validFrom, validUntil }: MapArea): string {
  const speed = kind === MapArea_Kind.SPEED_LIMIT ? ` ${speedLimitMps} m/s` : '';
  const robots = robotTypes.length > 0 ? `, for ${robotTypes.join(', ')}` : '';
  return `${kinds[kind]}${speed}${robots}${validFrom ? `, from ${at(validFrom)}` : ''}${validUntil ? `, until ${at(validUntil)}` : ''}`;
}

export const areaShown = ({ name, kind, outline }: MapArea): Area => ({
  name, tone: tones[kind] ?? 'other', corners: (outline?.corners ?? []).map(({ x, y }) => ({ x, y })),
});

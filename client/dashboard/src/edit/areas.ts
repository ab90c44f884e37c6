// SPDX-License-Identifier: Apache-2.0
// An area as a person enters it, and what of it has changed.
import { timestampFromMs, timestampMs, type Timestamp } from '@bufbuild/protobuf/wkt';
import { MapArea_Kind as Kind, type MapArea } from '../gen/enfilade/v1/map_area_pb';
import type { Point } from '../scene/camera';

export const kindNames: Record<Kind, string> = {
  [Kind.UNSPECIFIED]: 'Area', [Kind.KEEP_OUT]: 'Keep out', [Kind.SPEED_LIMIT]: 'Speed limit', [Kind.PREFERRED]: 'Preferred', [Kind.IGNORE_HITS]: 'Ignore hits (mirrors, glass)',
  [Kind.ROOM]: 'Room', [Kind.DOCK]: 'Dock',
};

export const kinds = [Kind.KEEP_OUT, Kind.SPEED_LIMIT, Kind.PREFERRED, Kind.IGNORE_HITS, Kind.ROOM, Kind.DOCK] as const;

// Texts as in the fields of the form. Times are in this computer's time zone; empty: without an end.
export interface AreaFields {
  title: string;
  kind: Kind;
  speed: string;
  types: string;
  from: string;
  until: string;
  // In metres of the map.
  corners: readonly Point[];
}

const two = (value: number) => String(value).padStart(2, '0');

// As <input type="datetime-local"> has it.
function timeText(time: Timestamp | undefined): string {
  if (!time) return '';
  const date = new Date(timestampMs(time));
  const seconds = date.getSeconds() === 0 ? '' : `:${two(date.getSeconds())}`;
  return `${String(date.getFullYear()).padStart(4, '0')}-${two(date.getMonth() + 1)}-${two(date.getDate())}T${two(date.getHours())}:${two(date.getMinutes())}${seconds}`;
}

const timeOf = (text: string): Timestamp | undefined => (text === '' ? undefined : timestampFromMs(new Date(text).getTime()));

const typesOf = (text: string) => text.split(/[\s,]+/).filter((type) => type !== '');

export const newFields: AreaFields = { title: '', kind: Kind.KEEP_OUT, speed: '', types: '', from: '', until: '', corners: [] };

export const fieldsOf = ({ displayName, kind, speedLimitMps, robotTypes, validFrom, validUntil, outline }: MapArea): AreaFields => ({
  title: displayName, kind, speed: speedLimitMps > 0 ? String(speedLimitMps) : '', types: robotTypes.join(', '), from: timeText(validFrom), until: timeText(validUntil),
  corners: (outline?.corners ?? []).map(({ x, y }) => ({ x, y })),
});

// Why the server would not take it, as far as that is known here.
export function problemOf({ title, kind, speed, from, until, corners }: AreaFields): string | undefined {
  if (title.trim() === '') return 'Enter a name.';
  if (corners.length < 3) return 'An area has at least three corners.';
  if (kind === Kind.SPEED_LIMIT && !(Number(speed) > 0)) return 'Enter the speed limit in metres per second, more than 0.';
  if ([from, until].some((text) => text !== '' && Number.isNaN(new Date(text).getTime()))) return 'Enter times with their date, or leave them empty.';
  return from !== '' && until !== '' && new Date(from) >= new Date(until) ? 'It ends before it begins: enter a later end.' : undefined;
}

// The fields of the message.
export function messageOf({ title, kind, speed, types, from, until, corners }: AreaFields) {
  const [validFrom, validUntil] = [timeOf(from), timeOf(until)];
  return {
    displayName: title.trim(), kind, outline: { corners: [...corners] }, robotTypes: typesOf(types), speedLimitMps: kind === Kind.SPEED_LIMIT ? Number(speed) : 0,
    ...(validFrom && { validFrom }), ...(validUntil && { validUntil }),
  };
}

const isSame = (a: readonly Point[], b: readonly Point[]) => a.length === b.length && a.every(({ x, y }, i) => x === b[i]!.x && y === b[i]!.y);

const paths = {
  title: ['display_name'], kind: ['kind', 'speed_limit_mps'], speed: ['speed_limit_mps'], types: ['robot_types'], from: ['valid_from'], until: ['valid_until'], corners: ['outline'],
} as const;

const names = Object.keys(paths) as (keyof AreaFields)[];

const differs = (name: keyof AreaFields, a: AreaFields, b: AreaFields) => (name === 'corners' ? !isSame(a.corners, b.corners) : a[name] !== b[name]);

// For an update mask. What a person has not touched is not sent: the form shows it rounded.
export const changedPaths = (fields: AreaFields, before: AreaFields): string[] =>
  [...new Set(names.filter((name) => differs(name, fields, before)).flatMap((name) => paths[name]))];

// What a person has changed on top of what somebody else has made of it.
export function laidOver(fields: AreaFields, before: AreaFields, theirs: AreaFields): AreaFields {
  const mine = names.filter((name) => differs(name, fields, before)).map((name) => [name, fields[name]]);
  return { ...theirs, ...(Object.fromEntries(mine) as Partial<AreaFields>) };
}

const labels = { title: 'Name', kind: 'Kind', speed: 'Speed limit', types: 'Robot types', from: 'Valid from', until: 'Valid until' } as const;

function said(name: keyof typeof labels, fields: AreaFields): string {
  if (name === 'kind') return kindNames[fields.kind];
  const text = fields[name].replace('T', name === 'from' || name === 'until' ? ' ' : 'T');
  return text !== '' ? text : name === 'types' ? 'all' : 'none';
}

// "Name: Lab, now Laboratory".
export function differencesOf(before: AreaFields, now: AreaFields): string[] {
  const lines = (Object.keys(labels) as (keyof typeof labels)[]).filter((name) => differs(name, before, now)).map((name) => `${labels[name]}: ${said(name, before)}, now ${said(name, now)}`);
  if (!isSame(before.corners, now.corners)) lines.push(`Outline: ${before.corners.length} corners, now ${now.corners.length === before.corners.length ? 'others' : now.corners.length}`);
  return lines;
}

const rounded = (value: number) => Number(value.toFixed(3));

// "0, 0; 2, 0; 1, 1.5".
export const cornersText = (corners: readonly Point[]) => corners.map(({ x, y }) => `${rounded(x)}, ${rounded(y)}`).join('; ');

// Corners that were typed; those that are as they were shown keep all their digits.
export const exactly = (typed: readonly Point[], shown: readonly Point[]): Point[] =>
  typed.map((point) => shown.find(({ x, y }) => rounded(x) === point.x && rounded(y) === point.y) ?? point);

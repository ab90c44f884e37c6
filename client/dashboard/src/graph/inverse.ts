// SPDX-License-Identifier: Apache-2.0
// The changes that take back what a transaction has done with link points, by the rules of docs/graph.md.
import { create } from '@bufbuild/protobuf';
import { timestampFromMs } from '@bufbuild/protobuf/wkt';
import { GraphChangeSchema, type GraphChange } from '../gen/enfilade/v1/graph_service_pb';
import { LinkPointSchema, LinkPoint_Use as Use, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import type { LinkPointChange, Row } from './audited';
import { kindNames, stateNames } from './differences';
import { anchorOf, changeOf, placeOf, samePlace, type AnchorPlace } from './draft';

export interface Inverse {
  changes: GraphChange[];
  // What it does, in words.
  lines: string[];
  // What cannot come back.
  warnings: string[];
  // Why it is not made: what somebody has changed since stays.
  refusals: string[];
}

const numberIn = (row: Row | undefined, name: string) => (typeof row?.[name] === 'number' ? (row[name] as number) : 0);
const textIn = (row: Row | undefined, name: string) => (typeof row?.[name] === 'string' ? (row[name] as string) : '');

// Undefined: the row is not as expected, and nothing may be made of it.
export function placeIn(row: Row | undefined): AnchorPlace | undefined {
  const covariance = row?.covariance;
  if (!Array.isArray(covariance) || covariance.length !== 9 || !covariance.every((value) => typeof value === 'number')) return undefined;
  if (![row?.x, row?.y, row?.yaw].every((value) => typeof value === 'number')) return undefined;
  return { pose: { x: numberIn(row, 'x'), y: numberIn(row, 'y'), yaw: numberIn(row, 'yaw') }, covariance: covariance as number[] };
}

// A column, its field of the API, and what it holds for people. The numbers of enums are those of the API.
interface Field {
  column: string;
  path: string;
  // Of a row, and of a link point: equal if they say the same.
  inRow: (row: Row | undefined, site: string) => string | number;
  in: (point: LinkPoint) => string | number;
  set: (point: LinkPoint, value: string | number) => void;
  text: (value: string | number) => string;
  // Unset: `column` is a word.
  called?: string;
}

const untilOf = (row: Row | undefined) => (textIn(row, 'valid_until') === '' ? '' : Date.parse(textIn(row, 'valid_until')));
const mapIn = (row: Row | undefined, site: string) => (textIn(row, 'direction_map_id') === '' ? '' : `${site}/maps/${textIn(row, 'direction_map_id')}`);

const fields: readonly Field[] = [
  { column: 'kind', path: 'kind', inRow: (row) => numberIn(row, 'kind'), in: ({ kind }) => kind, set: (point, value) => (point.kind = Number(value)), text: (value) => `its kind becomes: ${kindNames[value as LinkPoint['kind']]}` },
  { column: 'tag', path: 'tag', inRow: (row) => textIn(row, 'tag'), in: ({ tag }) => tag, set: (point, value) => (point.tag = String(value)), text: (value) => `its tag becomes “${value}”` },
  {
    column: 'direction_map_id', path: 'direction_map', inRow: mapIn, in: ({ directionMap }) => directionMap, set: (point, value) => (point.directionMap = String(value)),
    text: () => 'the map that was entered goes back',
  },
  {
    column: 'difficulty', path: 'difficulty', inRow: (row) => numberIn(row, 'difficulty'), in: ({ difficulty }) => difficulty, set: (point, value) => (point.difficulty = Number(value)),
    text: (value) => `its difficulty becomes ${value}`,
  },
  {
    column: 'environment', path: 'environment', inRow: (row) => numberIn(row, 'environment'), in: ({ environment }) => environment, set: (point, value) => (point.environment = Number(value)),
    text: () => 'its environment goes back',
  },
  { column: 'state', path: 'state', inRow: (row) => numberIn(row, 'state'), in: ({ state }) => state, set: (point, value) => (point.state = Number(value)), text: (value) => `its state becomes: ${stateNames[value as LinkPoint['state']]}` },
  {
    column: 'valid_until', path: 'state_valid_until', inRow: untilOf, in: ({ stateValidUntil }) => (stateValidUntil ? Number(stateValidUntil.seconds) * 1000 + Math.trunc(stateValidUntil.nanos / 1e6) : ''),
    set: (point, value) => (value === '' ? delete point.stateValidUntil : (point.stateValidUntil = timestampFromMs(Number(value)))), text: () => 'the end of its state goes back',
  },
  {
    column: 'pinned', path: 'pinned', inRow: (row) => (row?.pinned === true ? 1 : 0), in: ({ pinned }) => (pinned ? 1 : 0), set: (point, value) => (point.pinned = value === 1),
    text: (value) => (value === 1 ? 'it is pinned' : 'it is pinned no more'), called: 'pin',
  },
];

const siteOf = (linkPoint: string) => linkPoint.split('/').slice(0, 2).join('/');

interface Told {
  title: string;
  titleOf: (name: string) => string;
  out: Inverse;
}

function revived(change: LinkPointChange, { title, out }: Told) {
  const { linkPoint, row, anchors } = change;
  const places = [...anchors].map(([map, { before }]) => ({ map, place: placeIn(before), ordinal: numberIn(before, 'ordinal') }));
  if (places.length === 0 || places.some(({ place }) => !place)) {
    out.refusals.push(`${title}: the audit trail does not have its anchors, so it cannot come back.`);
    return;
  }
  places.sort((a, b) => a.ordinal - b.ordinal);
  const point = create(LinkPointSchema, { name: linkPoint, anchors: places.map(({ map, place }) => anchorOf(map, place!)) });
  for (const field of fields) field.set(point, field.inRow(row?.before, siteOf(linkPoint)));
  out.changes.push(create(GraphChangeSchema, { change: { case: 'created', value: point }, force: row?.before?.forced === true }));
  if (numberIn(row?.before, 'use') === Use.SUSPENDED) out.changes.push(changeOf({ case: 'suspended', value: linkPoint }));
  out.lines.push(`${title} is made again`);
  if (change.lostEvidence) out.warnings.push(`${title}: its pictures and clouds are gone and do not come back.`);
}

const changedSince = ({ title, out }: Told, what: string) => out.refusals.push(`${title}: ${what} has been changed since. Take that back first, or change it on the campus.`);

// Whether an anchor is as the transaction left it.
function isAsLeft(after: Row | undefined, is: AnchorPlace | undefined): boolean {
  const became = placeIn(after);
  return became ? is !== undefined && samePlace(is, became) : is === undefined;
}

function restoredAnchors(change: LinkPointChange, present: LinkPoint, told: Told): LinkPoint['anchors'] | undefined {
  if (change.anchors.size === 0) return undefined;
  const places = new Map(present.anchors.map((anchor) => [anchor.map, placeOf(anchor)]));
  for (const [map, { before, after }] of change.anchors) {
    if (!isAsLeft(after, places.get(map))) changedSince(told, `its anchor in ${told.titleOf(map)}`);
    const was = placeIn(before);
    if (was) {
      told.out.lines.push(`${told.title}: its anchor in ${told.titleOf(map)} ${places.has(map) ? 'goes' : 'comes'} back to ${was.pose.x.toFixed(2)}, ${was.pose.y.toFixed(2)} m`);
      places.set(map, was);
    } else {
      told.out.lines.push(`${told.title}: its anchor in ${told.titleOf(map)} is taken away`);
      places.delete(map);
    }
  }
  if (places.size === 0) told.out.refusals.push(`${told.title}: no anchor would be left. Delete it instead.`);
  return [...places].map(([map, place]) => anchorOf(map, place));
}

function restored(change: LinkPointChange, present: LinkPoint, told: Told) {
  const { linkPoint, row } = change;
  const point = create(LinkPointSchema, { ...present });
  const paths: string[] = [];
  const anchors = restoredAnchors(change, present, told);
  if (anchors) {
    point.anchors = anchors;
    paths.push('anchors');
  }
  for (const { column, path, inRow, in: now, set, text, called = column } of row ? fields : []) {
    const [was, became] = [row?.before, row?.after].map((one) => inRow(one, siteOf(linkPoint)));
    if (was === became) continue;
    if (now(present) !== became) changedSince(told, `its ${called}`);
    set(point, was!);
    paths.push(path);
    told.out.lines.push(`${told.title}: ${text(was!)}`);
  }
  if (paths.length > 0) told.out.changes.push(create(GraphChangeSchema, { change: { case: 'updated', value: point }, updateMask: { paths } }));
  restoreUse(change, present, paths.length > 0, told);
}

// What the optimisation has switched off is not people's to take back.
function restoreUse({ linkPoint, row }: LinkPointChange, present: LinkPoint, isUpdated: boolean, told: Told) {
  if (!row) return;
  const [was, became] = [row.before, row.after].map((one) => numberIn(one, 'use') === Use.SUSPENDED);
  if (was === became) return;
  if ((present.use === Use.SUSPENDED) !== became) return void changedSince(told, 'whether it is suspended');
  told.out.changes.push(changeOf({ case: was ? 'suspended' : 'resumed', value: linkPoint }, isUpdated ? '' : present.etag));
  told.out.lines.push(`${told.title} is ${was ? 'suspended' : 'resumed'}`);
}

function removed({ linkPoint, row, anchors }: LinkPointChange, present: LinkPoint, told: Told) {
  const isSame = present.tag === textIn(row?.after, 'tag') && present.anchors.length === anchors.size && present.anchors.every((anchor) => isAsLeft(anchors.get(anchor.map)?.after, placeOf(anchor)));
  if (!isSame) changedSince(told, 'it');
  told.out.changes.push(changeOf({ case: 'deleted', value: linkPoint }, present.etag));
  told.out.lines.push(`${told.title} is deleted`);
}

// `present`: the link points as they are now; undefined: it is gone.
export function inverseOf(changes: readonly LinkPointChange[], present: ReadonlyMap<string, LinkPoint | undefined>, titleOf: (name: string) => string): Inverse {
  const out: Inverse = { changes: [], lines: [], warnings: [], refusals: [] };
  for (const change of changes) {
    const { linkPoint, row } = change;
    const is = present.get(linkPoint);
    const told: Told = { title: titleOf(linkPoint), titleOf, out };
    if (row && !row.before && !row.after) continue;
    if (row && !row.after) {
      if (is) out.refusals.push(`${told.title} is there again already.`);
      else revived(change, told);
    } else if (!is) {
      out.refusals.push(`${told.title} has been deleted since. Take back its deletion first.`);
    } else if (row && !row.before) {
      removed(change, is, told);
    } else {
      restored(change, is, told);
    }
  }
  return out;
}

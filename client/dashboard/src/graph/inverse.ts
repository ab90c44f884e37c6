// SPDX-License-Identifier: Apache-2.0
// The changes that take back what a transaction has done with link points.
import { create } from '@bufbuild/protobuf';
import { timestampFromMs } from '@bufbuild/protobuf/wkt';
import { GraphChangeSchema, type GraphChange } from '../gen/enfilade/v1/graph_service_pb';
import { LinkPointSchema, LinkPoint_Use as Use, type LinkPoint } from '../gen/enfilade/v1/link_point_pb';
import type { LinkPointChange, Row } from './audited';
import { anchorOf, anchorsOf, changesOf, editOf, samePlace, type AnchorPlace, type Edit } from './draft';
import { kindNames, stateNames } from './differences';

export interface Inverse {
  changes: GraphChange[];
  // What it does, in words.
  lines: string[];
  // What somebody has changed since, and what cannot come back.
  warnings: string[];
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

const mapNameIn = (site: string, row: Row | undefined, column: string) => (textIn(row, column) === '' ? '' : `${site}/maps/${textIn(row, column)}`);

// The numbers of kinds, states, uses and environments are those of the API.
function linkPointOf({ linkPoint, row, anchors }: LinkPointChange): LinkPoint {
  const before = row?.before;
  const site = linkPoint.split('/').slice(0, 2).join('/');
  const until = Date.parse(textIn(before, 'valid_until'));
  const places = [...anchors].flatMap(([map, change]) => {
    const place = placeIn(change.before);
    return place ? [{ map, place, ordinal: numberIn(change.before, 'ordinal') }] : [];
  });
  places.sort((a, b) => a.ordinal - b.ordinal);
  return create(LinkPointSchema, {
    name: linkPoint, kind: numberIn(before, 'kind'), tag: textIn(before, 'tag'), directionMap: mapNameIn(site, before, 'direction_map_id'),
    difficulty: numberIn(before, 'difficulty'), environment: numberIn(before, 'environment'), state: numberIn(before, 'state'),
    ...(Number.isFinite(until) && { stateValidUntil: timestampFromMs(until) }),
    anchors: places.map(({ map, place }) => anchorOf(map, place)),
  });
}

interface Told {
  title: string;
  titleOf: (name: string) => string;
  out: Inverse;
}

function revive(change: LinkPointChange, { title, out }: Told) {
  const point = linkPointOf(change);
  if (point.anchors.length === 0) {
    out.warnings.push(`${title}: the audit trail does not have its anchors, so it cannot come back.`);
    return;
  }
  out.changes.push(create(GraphChangeSchema, { change: { case: 'created', value: point } }));
  if (numberIn(change.row?.before, 'use') === Use.SUSPENDED) out.changes.push(create(GraphChangeSchema, { change: { case: 'suspended', value: change.linkPoint } }));
  out.lines.push(`${title} is made again`);
  if (change.lostEvidence) out.warnings.push(`${title}: its pictures and clouds are gone and do not come back.`);
}

// Of the anchors: the edit with what they were.
function restoredAnchors(change: LinkPointChange, edit: Edit, { title, titleOf, out }: Told): Edit {
  const anchors: Record<string, AnchorPlace | null> = {};
  const present = anchorsOf(edit);
  for (const [map, { before, after }] of change.anchors) {
    const [was, became, is] = [placeIn(before), placeIn(after), present.get(map)];
    const isAsLeft = became ? is !== undefined && samePlace(is, became) : is === undefined;
    if (!isAsLeft) out.warnings.push(`${title}: its anchor in ${titleOf(map)} has been changed since; that is replaced, too.`);
    if (was) {
      anchors[map] = was;
      out.lines.push(`${title}: its anchor in ${titleOf(map)} ${became ? 'goes back' : 'comes back'} to ${was.pose.x.toFixed(2)}, ${was.pose.y.toFixed(2)} m`);
    } else if (is) {
      anchors[map] = null;
      out.lines.push(`${title}: its anchor in ${titleOf(map)} is taken away`);
    }
  }
  return { ...edit, anchors };
}

function restoredRow({ row }: LinkPointChange, edit: Edit, { title, out }: Told): Edit {
  const [before, after] = [row?.before, row?.after];
  if (!before || !after) return edit;
  const next: Edit = { ...edit, base: create(LinkPointSchema, { ...edit.base }) };
  const differs = (name: string) => before[name] !== after[name];
  const since = (name: string, is: unknown) => {
    if (is !== (after[name] ?? '')) out.warnings.push(`${title}: its ${name} has been changed since; that is replaced, too.`);
  };
  if (differs('kind')) {
    since('kind', edit.base.kind);
    next.kind = numberIn(before, 'kind');
    out.lines.push(`${title} becomes: ${kindNames[next.kind as LinkPoint['kind']]}`);
  }
  if (differs('state')) {
    since('state', edit.base.state);
    next.state = numberIn(before, 'state');
    out.lines.push(`${title} becomes: ${stateNames[next.state as LinkPoint['state']]}`);
  }
  return next;
}

function restored(change: LinkPointChange, present: LinkPoint, told: Told) {
  const { title, out } = told;
  const edit = restoredRow(change, restoredAnchors(change, editOf(present), told), told);
  const [was, became] = [numberIn(change.row?.before, 'use'), numberIn(change.row?.after, 'use')];
  const isUse = change.row?.before !== undefined && (was === Use.SUSPENDED) !== (became === Use.SUSPENDED) && (present.use === Use.SUSPENDED) !== (was === Use.SUSPENDED);
  if (isUse) {
    edit.use = was === Use.SUSPENDED ? 'suspended' : 'resumed';
    out.lines.push(`${title} is ${edit.use}`);
  }
  if (anchorsOf(edit).size === 0) {
    out.warnings.push(`${title}: no anchor would be left. Delete it instead.`);
    return;
  }
  const changes = changesOf(new Map([[change.linkPoint, edit]]));
  // A tag or a difficulty is no part of an edit: the change is made of what is there, with these put back.
  const fields = restoredFields(change, told);
  if (fields && changes.length === 0) changes.push(create(GraphChangeSchema, { change: { case: 'updated', value: create(LinkPointSchema, { ...present }) } }));
  for (const { change: made } of changes) if (made.case === 'updated' && fields) Object.assign(made.value, fields);
  out.changes.push(...changes);
}

function restoredFields({ row }: LinkPointChange, { title, out }: Told): Partial<Pick<LinkPoint, 'tag' | 'difficulty'>> | undefined {
  const [before, after] = [row?.before, row?.after];
  if (!before || !after) return undefined;
  const fields: Partial<Pick<LinkPoint, 'tag' | 'difficulty'>> = {};
  if (before.tag !== after.tag) fields.tag = textIn(before, 'tag');
  if (before.difficulty !== after.difficulty) fields.difficulty = numberIn(before, 'difficulty');
  for (const [name, value] of Object.entries(fields)) out.lines.push(`${title}: its ${name} becomes “${value}”`);
  return Object.keys(fields).length > 0 ? fields : undefined;
}

// `present`: the link points as they are now; undefined: it is gone.
export function inverseOf(changes: readonly LinkPointChange[], present: ReadonlyMap<string, LinkPoint | undefined>, titleOf: (name: string) => string): Inverse {
  const out: Inverse = { changes: [], lines: [], warnings: [] };
  for (const change of changes) {
    const { linkPoint, row } = change;
    const is = present.get(linkPoint);
    const told: Told = { title: titleOf(linkPoint), titleOf, out };
    if (row && !row.before && !row.after) continue;
    if (row && !row.after) {
      if (is) out.warnings.push(`${told.title} is there again already.`);
      else revive(change, told);
    } else if (!is) {
      out.warnings.push(`${told.title} has been deleted since: nothing of it can be taken back. Take back its deletion first.`);
    } else if (row && !row.before) {
      out.changes.push(...changesOf(new Map([[linkPoint, { ...editOf(is), isDeleted: true }]])));
      out.lines.push(`${told.title} is deleted`);
    } else {
      restored(change, is, told);
    }
  }
  return out;
}


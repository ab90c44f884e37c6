// SPDX-License-Identifier: Apache-2.0
// What the audit trail tells of link points: rows of the tables link_points and link_point_anchors before and after, as JSON.
import { timestampMs, type Timestamp } from '@bufbuild/protobuf/wkt';
import { AuditEntry_Action as Action, type AuditEntry } from '../gen/enfilade/v1/site_service_pb';

export type Row = Readonly<Record<string, unknown>>;

// One row, over all entries of one transaction. Undefined: it was not there.
export interface RowChange {
  before: Row | undefined;
  after: Row | undefined;
}

// All that one transaction has done with one link point.
export interface LinkPointChange {
  // sites/{site}/linkPoints/{link_point}
  linkPoint: string;
  // Undefined: only anchors have changed.
  row: RowChange | undefined;
  // By map: sites/{site}/maps/{map}.
  anchors: ReadonlyMap<string, RowChange>;
  // Pictures or clouds went with it.
  lostEvidence: boolean;
}

export function rowOf(text: string): Row | undefined {
  if (text === '') return undefined;
  try {
    const value: unknown = JSON.parse(text);
    return value !== null && typeof value === 'object' && !Array.isArray(value) ? (value as Row) : undefined;
  } catch {
    return undefined;
  }
}

const pattern = /^(sites\/[^/]+)\/linkPoints\/([^/]+)(?:\/(anchors|evidence)\/([^/]+)(?:\/[^/]+)?)?$/;

// Pictures and clouds cannot be taken back by themselves.
export const mayTakeBack = ({ resource }: Pick<AuditEntry, 'resource'>) => pattern.exec(resource) !== null && !resource.includes('/evidence/');

export const sameTime = (a: Timestamp | undefined, b: Timestamp | undefined) => a !== undefined && b !== undefined && a.seconds === b.seconds && a.nanos === b.nanos;

// All entries of one transaction have its time and its actor.
export const transactionOf = (entries: readonly AuditEntry[], one: AuditEntry) =>
  entries.filter((entry) => sameTime(entry.time, one.time) && entry.actor === one.actor);

export const timeOf = ({ time }: AuditEntry) => (time ? timestampMs(time) : 0);

// `entries`: the newest first.
function overall(entries: readonly AuditEntry[]): RowChange {
  const [newest, oldest] = [entries[0]!, entries.at(-1)!];
  return { before: rowOf(oldest.before), after: rowOf(newest.after) };
}

// What a transaction has done with link points; `entries`: the newest first, of one transaction.
export function changesIn(entries: readonly AuditEntry[]): LinkPointChange[] {
  const found = new Map<string, { rows: AuditEntry[]; anchors: Map<string, AuditEntry[]>; lostEvidence: boolean }>();
  for (const entry of entries) {
    const [, site, id, part, map] = pattern.exec(entry.resource) ?? [];
    if (site === undefined || id === undefined) continue;
    const name = `${site}/linkPoints/${id}`;
    const one = found.get(name) ?? { rows: [], anchors: new Map<string, AuditEntry[]>(), lostEvidence: false };
    found.set(name, one);
    if (part === undefined) one.rows.push(entry);
    else if (part === 'evidence') one.lostEvidence ||= entry.action === Action.DELETED;
    else one.anchors.set(`${site}/maps/${map!}`, [...(one.anchors.get(`${site}/maps/${map!}`) ?? []), entry]);
  }
  return [...found].map(([linkPoint, { rows, anchors, lostEvidence }]) => ({
    linkPoint, row: rows.length > 0 ? overall(rows) : undefined, anchors: new Map([...anchors].map(([map, list]) => [map, overall(list)])), lostEvidence,
  }));
}

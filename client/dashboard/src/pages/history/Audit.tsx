// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { useState } from 'react';
import { sites } from '../../api/clients';
import { siteName, withoutSite } from '../../api/names';
import { mayTakeBack } from '../../graph/audited';
import { AuditEntry_Action as Action, type AuditEntry } from '../../gen/enfilade/v1/site_service_pb';
import { useLive } from '../../live/context';
import { DataTable, type Column } from '../../ui/DataTable';
import { dateTime, shortened } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';
import { TakeBack } from './TakeBack';

const SHOWN = 1000;

const actions: Record<Action, string> = {
  [Action.UNSPECIFIED]: 'Changed',
  [Action.CREATED]: 'Created',
  [Action.UPDATED]: 'Changed',
  [Action.DELETED]: 'Deleted',
};

function parsed(text: string): Record<string, unknown> {
  try {
    return JSON.parse(text || '{}') as Record<string, unknown>;
  } catch {
    return {};
  }
}

// The fields that differ, as "name: before → after".
function differences({ before, after }: AuditEntry): string[] {
  const [old, now] = [parsed(before), parsed(after)];
  const names = [...new Set([...Object.keys(old), ...Object.keys(now)])].sort();
  const text = (value: unknown) => (value === undefined ? '–' : JSON.stringify(value));
  return names.filter((name) => text(old[name]) !== text(now[name])).map((name) => `${name}: ${text(old[name])} → ${text(now[name])}`);
}

function Difference({ entry }: { entry: AuditEntry }) {
  const lines = differences(entry);
  if (lines.length === 0) return <span className="sub">nothing that is kept</span>;
  return (
    <details>
      <summary>{lines.length === 1 ? '1 field' : `${lines.length} fields`}</summary>
      <pre className="mono">{lines.join('\n')}</pre>
    </details>
  );
}

// Of the site itself the name without the site is empty.
const resourceOf = ({ resource }: AuditEntry) => (/^sites\/[^/]+$/.test(resource) ? 'the site' : withoutSite(resource));

const columns: Column<AuditEntry>[] = [
  { title: 'Time', order: ({ time }) => (time ? timestampMs(time) : 0), cell: ({ time }) => time && dateTime(timestampMs(time)) },
  { title: 'Who', order: ({ actor }) => actor, cell: ({ actor }) => actor || <span className="sub">unknown</span> },
  { title: 'Did', order: ({ action }) => actions[action], cell: ({ action }) => actions[action] },
  { title: 'What', order: resourceOf, cell: (entry) => <span className="mono" title={resourceOf(entry)}>{shortened(resourceOf(entry))}</span> },
  { title: 'Difference', cell: (entry) => <Difference entry={entry} /> },
];

export function Audit() {
  const live = useLive();
  const [asked, setAsked] = useState<AuditEntry>();
  const { data, error, refetch } = useQuery({
    queryKey: ['audit', live.id],
    queryFn: async () => (await sites.listAuditEntries({ parent: siteName(live.id), pageSize: SHOWN })).entries,
  });
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (data.length === 0) return <Empty title="No entries">Nobody has changed this site, or its audit trail is not kept so long.</Empty>;
  const rows = data.map((entry, i) => ({ entry, key: String(i) }));
  const all: Column<AuditEntry>[] = [...columns, {
    title: 'Change',
    cell: (entry) => mayTakeBack(entry) && (
      <button className="button" aria-label={`Take back: ${actions[entry.action]} ${resourceOf(entry)}`} onClick={() => setAsked(entry)}>
        Take back …
      </button>
    ),
  }];
  return (
    <>
      {asked && <TakeBack key={`${asked.time?.seconds} ${asked.time?.nanos}`} entries={data} entry={asked} isCut={data.length === SHOWN} done={() => setAsked(undefined)} />}
      <DataTable caption="Audit trail" noun={['entry', 'entries']} rows={rows} keyOf={({ key }) => key}
        columns={all.map(({ cell, order, ...column }) => ({ ...column, cell: (row: { entry: AuditEntry }) => cell(row.entry), ...(order && { order: (row: { entry: AuditEntry }) => order(row.entry) }) }))}
        textOf={({ entry }) => `${entry.actor} ${actions[entry.action]} ${resourceOf(entry)}`} />
    </>
  );
}

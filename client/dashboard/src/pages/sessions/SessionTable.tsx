// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { collect, sessions } from '../../api/clients';
import { idOf, siteName } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import type { Session } from '../../gen/enfilade/v1/session_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import type { LiveSite } from '../../live/site';
import { Badge } from '../../ui/Badge';
import { DataTable, type Column } from '../../ui/DataTable';
import { dateTime, perSecond } from '../../ui/format';
import { stateOfSession } from './states';

// All sessions of the site, the latest first.
export function useSessions() {
  const live = useLive();
  return useQuery({
    queryKey: ['sessions', live.id, live.sessions.size],
    placeholderData: (earlier: Session[] | undefined) => earlier,
    queryFn: async () => {
      const all = await collect(async (pageToken) => {
        const answer = await sessions.listSessions({ parent: siteName(live.id), pageSize: 1000, pageToken });
        return [answer.sessions, answer.nextPageToken];
      });
      return all.sort((a, b) => begunAt(b) - begunAt(a));
    },
  });
}

// The stream knows more of sessions that go on than the list, which was read when the page was opened.
const current = (live: LiveSite, session: Session) => live.sessions.get(session.name) ?? session;

export const begunAt = ({ createTime }: Session) => (createTime ? timestampMs(createTime) : 0);

function columnsOf(live: LiveSite): Column<Session>[] {
  return [
    {
      title: 'Session',
      cell: ({ name }) => (
        <Link className="mono" href={addressOf(live.id, 'sessions', [idOf(name)])} title={idOf(name)}>
          {idOf(name).slice(0, 8)}
        </Link>
      ),
    },
    { title: 'Robot', order: ({ robot }) => idOf(robot), cell: ({ robot }) => idOf(robot) },
    {
      title: 'State', order: (session) => current(live, session).state,
      cell: (session) => {
        const [tone, text] = stateOfSession[current(live, session).state];
        return <Badge tone={tone}>{text}</Badge>;
      },
    },
    {
      title: 'Map', order: (session) => titleOf(live, current(live, session).map),
      cell: (session) => {
        const { map } = current(live, session);
        return map === '' ? <span className="sub">not decided yet</span> : <Link href={addressOf(live.id, 'maps', [idOf(map)])}>{titleOf(live, map)}</Link>;
      },
    },
    { title: 'Stored', number: true, order: (session) => Number(current(live, session).acknowledgedSequence), cell: (session) => String(current(live, session).acknowledgedSequence) },
    {
      title: 'Rate', number: true, order: ({ name }) => live.recordRate(name), cell: ({ name }) => perSecond(live.recordRate(name)),
    },
    { title: 'Mapped', number: true, order: (session) => Number(current(live, session).mappedSequence), cell: (session) => String(current(live, session).mappedSequence) },
    { title: 'Begun', order: begunAt, cell: (session) => dateTime(begunAt(session)) },
  ];
}

export function SessionTable({ rows }: { rows: Session[] }) {
  const live = useLive();
  return (
    <DataTable caption="Sessions" noun={['session', 'sessions']} rows={rows} columns={columnsOf(live)} keyOf={({ name }) => name}
      textOf={(session) => `${idOf(session.name)} ${idOf(session.robot)} ${titleOf(live, current(live, session).map)} ${stateOfSession[current(live, session).state][1]}`} />
  );
}

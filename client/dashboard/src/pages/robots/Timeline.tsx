// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { Session_State, type Session } from '../../gen/enfilade/v1/session_pb';
import { useLive, useNow } from '../../live/context';
import { titleOf } from '../../live/objects';
import { clock, dateTime } from '../../ui/format';
import { begunAt } from '../sessions/SessionTable';

// Older ones are in the table only: they would make the bars of the latest too narrow to hit.
const SHOWN = 20;

// The latest sessions of a robot, each as a bar from its begin to its end, named by the map that it drove in.
export function Timeline({ sessions }: { sessions: Session[] }) {
  const live = useLive();
  const now = useNow(5000) - live.clockOffset;
  const shown = sessions.slice(0, SHOWN).reverse();
  const spans = shown.map((session) => {
    const { state, map } = live.sessions.get(session.name) ?? session;
    const from = begunAt(session);
    const finished = session.finishTime ? timestampMs(session.finishTime) : from;
    const to = state === Session_State.RECORDING ? Math.max(now, from) : finished;
    return { name: session.name, title: map === '' ? 'not decided yet' : titleOf(live, map), from, to, failed: state === Session_State.FAILED };
  });
  const begin = spans[0]!.from;
  const end = Math.max(...spans.map(({ to }) => to), begin + 1000);
  const percent = (ms: number) => `${(100 * ms) / (end - begin)}%`;
  return (
    <section className="card timeline" aria-label="Sessions over time">
      <div className="timeline-bars">
        {spans.map(({ name, title, from, to, failed }) => (
          <Link key={name} className={failed ? 'timeline-bar bad' : 'timeline-bar'} href={addressOf(live.id, 'sessions', [idOf(name)])} title={`${title}, ${dateTime(from)} to ${clock(to)}`}
            style={{ left: percent(from - begin), width: percent(to - from) }}>
            {title}
          </Link>
        ))}
      </div>
      <div className="timeline-ends sub">
        <span>{dateTime(begin)}</span>
        <span>{dateTime(end)}</span>
      </div>
    </section>
  );
}

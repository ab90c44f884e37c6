// SPDX-License-Identifier: Apache-2.0
import './history.css';
import { addressOf, Link, usePlace } from '../../app/router';
import { useLive } from '../../live/context';
import { Audit } from './Audit';
import { Rearrangements } from './Rearrangements';
import { Timeline } from './Timeline';
import { Versions } from './Versions';

const tabs = [['', 'Maps over time'], ['versions', 'Graph'], ['rearranged', 'Merges and splits'], ['audit', 'Audit trail']] as const;

// How the maps have moved, how the graph has changed, and who changed what.
export default function HistoryPage() {
  const live = useLive();
  const { rest } = usePlace();
  const shown = rest[0] ?? '';
  return (
    <div className={shown === '' ? 'whole' : 'page'}>
      <div className="page-head">
        <h1>History</h1>
        <nav className="tabs" aria-label="Kinds of history">
          {tabs.map(([path, title]) => (
            <Link key={path} className="button" href={addressOf(live.id, 'history', path === '' ? [] : [path])} aria-current={path === shown ? 'page' : undefined}>
              {title}
            </Link>
          ))}
        </nav>
      </div>
      {shown === '' ? <Timeline /> : shown === 'audit' ? <Audit /> : shown === 'rearranged' ? <Rearrangements /> : <Versions />}
    </div>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { addressOf, Link, usePlace } from '../../app/router';
import { useLive } from '../../live/context';
import { Audit } from './Audit';
import { Versions } from './Versions';

// How the graph has changed, and who changed what.
export default function HistoryPage() {
  const live = useLive();
  const { rest } = usePlace();
  const isAudit = rest[0] === 'audit';
  return (
    <div className="page">
      <div className="page-head">
        <h1>History</h1>
        <nav className="tabs" aria-label="Kinds of history">
          <Link className="button" href={addressOf(live.id, 'history')} aria-current={isAudit ? undefined : 'page'}>Graph</Link>
          <Link className="button" href={addressOf(live.id, 'history', ['audit'])} aria-current={isAudit ? 'page' : undefined}>Audit trail</Link>
        </nav>
      </div>
      {isAudit ? <Audit /> : <Versions />}
    </div>
  );
}

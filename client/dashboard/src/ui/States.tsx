// SPDX-License-Identifier: Apache-2.0
// What a page shows while it has nothing to show: each says why, and what to do.
import type { ReactNode } from 'react';
import { problemOf } from '../api/errors';

export function Loading({ rows = 6 }: { rows?: number }) {
  return (
    <div className="skeletons" role="status" aria-label="Loading">
      {Array.from({ length: rows }, (_, i) => (
        <span key={i} className="skeleton" style={{ width: `${45 + ((i * 37) % 50)}%` }} />
      ))}
    </div>
  );
}

export function Empty({ title, children, command }: { title: string; children: ReactNode; command?: string }) {
  return (
    <div className="state">
      <h2>{title}</h2>
      <p>{children}</p>
      {command !== undefined && <code>{command}</code>}
    </div>
  );
}

export function Failed({ error, retry }: { error: unknown; retry?: () => void }) {
  const { title, text, remedy, requestId } = problemOf(error);
  return (
    <div className="state" role="alert">
      <h2>{title}</h2>
      <p>{text}</p>
      <p>{remedy}</p>
      {retry && (
        <button className="button" onClick={retry}>
          Try again
        </button>
      )}
      {requestId !== undefined && <span className="request mono">request {requestId}</span>}
    </div>
  );
}

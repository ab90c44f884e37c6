// SPDX-License-Identifier: Apache-2.0
import './styles/confirm.css';
import type { ReactNode } from 'react';

interface Props {
  title: string;
  lines: readonly string[];
  refusal?: string | undefined;
  // On the buttons: does it, and leaves it.
  act: string;
  keep: string;
  busy: boolean;
  onAct: () => void;
  onKeep: () => void;
  children?: ReactNode;
}

// Says what will happen before it does.
export function Confirm({ title, lines, refusal, act, keep, busy, onAct, onKeep, children }: Props) {
  return (
    <section className="confirm" role="group" aria-label={title}>
      <h3>{title}</h3>
      {children}
      <ul>
        {lines.map((line) => (
          <li key={line}>{line}</li>
        ))}
      </ul>
      {refusal !== undefined && <p className="refusal">{refusal}</p>}
      <div className="actions">
        <button className="button primary" disabled={busy || refusal !== undefined} onClick={onAct}>
          {act}
        </button>
        <button className="button" disabled={busy} onClick={onKeep}>
          {keep}
        </button>
      </div>
    </section>
  );
}

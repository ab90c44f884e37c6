// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';

interface Props {
  title: string;
  question: string;
  keep: string;
  act: string;
  busy: boolean;
  onAct: () => void;
}

// A second button, so that nothing is lost by one click.
export function Sure({ title, question, keep, act, busy, onAct }: Props) {
  const [isAsking, setAsking] = useState(false);
  if (!isAsking) {
    return (
      <button className="button" disabled={busy} onClick={() => setAsking(true)}>
        {title}
      </button>
    );
  }
  return (
    <span className="edit-question" role="group" aria-label={question}>
      {question}
      <button className="button" autoFocus onClick={() => setAsking(false)}>
        {keep}
      </button>
      <button className="button edit-danger" disabled={busy} onClick={() => { setAsking(false); onAct(); }}>
        {act}
      </button>
    </span>
  );
}

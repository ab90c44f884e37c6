// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';

interface Props {
  // The button, and what it asks before it acts.
  title: string;
  question: string;
  yes: string;
  no: string;
  busy: boolean;
  act: () => void;
}

// A second button, so that nothing is changed by one click.
export function Question({ title, question, yes, no, busy, act }: Props) {
  const [isAsking, setAsking] = useState(false);
  if (!isAsking) {
    return (
      <button className="button small-text" disabled={busy} onClick={() => setAsking(true)}>
        {title}
      </button>
    );
  }
  return (
    <span className="question" role="group" aria-label={question}>
      {question}
      <button className="button small-text" autoFocus onClick={() => setAsking(false)}>
        {no}
      </button>
      <button className="button small-text" disabled={busy} onClick={() => { setAsking(false); act(); }}>
        {yes}
      </button>
    </span>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { useState, type FormEvent } from 'react';
import { author } from './author';

// Asks for the name once; `done` where it is being changed.
export function AuthorForm({ done }: { done?: () => void }) {
  const [text, setText] = useState(author.get());
  const [problem, setProblem] = useState('');
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    if (text.trim() === '') return setProblem('Enter a name.');
    author.set(text.trim());
    done?.();
  };
  return (
    <form className="edit-author" aria-label="Who edits" onSubmit={onSubmit} noValidate>
      <label>
        Your name
        <input className="field" autoFocus autoComplete="name" maxLength={64} value={text} onChange={(event) => setText(event.target.value)} />
      </label>
      <p className="sub">Others see it beside your edits. This browser keeps it.</p>
      {problem !== '' && <p className="refusal" role="alert">{problem}</p>}
      <button className="button primary">Continue</button>
    </form>
  );
}

// Who edits, with a way to change it.
export function AuthorLine() {
  const name = author.use();
  const [isChanging, setChanging] = useState(false);
  if (isChanging) return <AuthorForm done={() => setChanging(false)} />;
  return (
    <p className="edit-line">
      <span>
        You edit as <strong>{name}</strong>
      </span>
      <button className="button small-text" onClick={() => setChanging(true)}>
        Change
      </button>
    </p>
  );
}

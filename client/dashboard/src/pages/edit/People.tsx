// SPDX-License-Identifier: Apache-2.0
import type { EditSession } from '../../edit/session';

// Who else has the draft open. The canvas shows their pointers.
export function People({ session }: { session: EditSession }) {
  const others = session.presences.filter(({ clientId }) => clientId !== session.clientId);
  return (
    <section className="inspector-part" aria-label="Also here">
      <h2>
        Also here <span className="sub">{others.length}</span>
      </h2>
      {others.length === 0 && <p className="sub">Nobody else has this draft open. Send its address to work on it together.</p>}
      <ul>
        {others.map(({ clientId, author, tool }) => (
          <li key={clientId}>
            {author || 'Somebody'} {tool !== '' && <span className="sub">{tool}</span>}
          </li>
        ))}
      </ul>
    </section>
  );
}

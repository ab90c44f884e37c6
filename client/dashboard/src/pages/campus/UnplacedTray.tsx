// SPDX-License-Identifier: Apache-2.0
import { select } from '../../app/selection';
import { useLive } from '../../live/context';
import { unplacedOf } from '../../live/unplaced';
import { Shape } from '../../ui/Badge';

export function UnplacedTray({ level }: { level: number | undefined }) {
  const found = unplacedOf(useLive(), level);
  if (found.length === 0) return null;
  return (
    <details className="unplaced">
      <summary>
        <span className="badge warn">
          <Shape tone="warn" />
          Not placed ({found.length})
        </span>
      </summary>
      <ul>
        {found.map(({ name, title, kind, reason }) => (
          <li key={name}>
            <button className="unplaced-item" onClick={() => select(name)}>
              <span>
                {kind === 'map' ? 'Map' : 'Robot'} <strong>{title}</strong>
              </span>
              <span className="sub">{reason}</span>
            </button>
          </li>
        ))}
      </ul>
    </details>
  );
}

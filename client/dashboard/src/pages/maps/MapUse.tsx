// SPDX-License-Identifier: Apache-2.0
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { byName } from '../../ui/format';
import { Icon } from '../../ui/Icon';

// Who needs this map: the robots that are in it, and the sessions that were mapped into it.
export function MapUse({ map }: { map: string }) {
  const live = useLive();
  const robots = live.robots.names.filter((_, row) => live.robots.maps[row] === map).sort(byName);
  return (
    <section>
      <h2>
        Robots in it <span className="sub">{robots.length}</span>
      </h2>
      <ul className="link-list">
        {robots.map((name) => (
          <li key={name}>
            <Link className="object" href={addressOf(live.id, 'robots', [idOf(name)])}>
              <Icon name="robot" />
              <span className="object-title">{idOf(name)}</span>
            </Link>
          </li>
        ))}
      </ul>
      <p className="sub">
        <Link href={addressOf(live.id, 'sessions', [], { q: titleOf(live, map) })}>Sessions in this map</Link>
      </p>
    </section>
  );
}

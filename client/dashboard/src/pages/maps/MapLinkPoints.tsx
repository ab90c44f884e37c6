// SPDX-License-Identifier: Apache-2.0
import { select, useSelection } from '../../app/selection';
import { useLive } from '../../live/context';
import { kindOf, stateOf, titleOf } from '../../live/objects';
import { Badge } from '../../ui/Badge';

// Where this map meets others.
export function MapLinkPoints({ map }: { map: string }) {
  const live = useLive();
  const selected = useSelection();
  const points = [...live.linkPoints.values()].filter((point) => point.maps.includes(map));
  return (
    <section>
      <h2>
        Link points <span className="sub">{points.length}</span>
      </h2>
      {points.length === 0 && <p className="sub">None: this map is joined to no other one. A robot that drives through one of its doors makes the first.</p>}
      <ul className="link-list">
        {points.map((point) => {
          const others = point.maps.filter((name) => name !== map).map((name) => titleOf(live, name));
          const { tone, text } = stateOf(point);
          return (
            <li key={point.linkPoint}>
              <button className="object" aria-pressed={selected === point.linkPoint} onClick={() => select(point.linkPoint)}>
                <span className="object-title">
                  {kindOf(point)} {others.length > 0 ? `to ${others.join(', ')}` : '(candidate)'}
                </span>
                <Badge tone={tone}>{text.split(':')[0]}</Badge>
              </button>
            </li>
          );
        })}
      </ul>
    </section>
  );
}

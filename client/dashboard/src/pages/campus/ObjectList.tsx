// SPDX-License-Identifier: Apache-2.0
import { useMemo, useRef, useState, type KeyboardEvent } from 'react';
import { idOf } from '../../api/names';
import { select, useSelection } from '../../app/selection';
import { useLive, useNow } from '../../live/context';
import { levelsOf, stateOf, titleOf } from '../../live/objects';
import type { LiveSite } from '../../live/site';
import { useInView } from '../../scene/shared';
import { Badge, type Tone } from '../../ui/Badge';
import { age, byName, count } from '../../ui/format';
import { Icon, type IconName } from '../../ui/Icon';

interface Item {
  name: string;
  title: string;
  icon: IconName;
  tone: Tone;
  note: string;
}

// After this a robot's pose counts as old.
export const STALE_S = 10;

function itemsOf(site: LiveSite, level: number | undefined, now: number, inView: ReadonlySet<string> | undefined): Item[] {
  const items: Item[] = [];
  const shows = (name: string) => inView?.has(name) ?? true;
  const onLevel = (levels: number[]) => level === undefined || levels.includes(level);
  for (const name of [...site.robots.names].sort(byName)) {
    if (!shows(name)) continue;
    const robot = site.robots.get(name)!;
    if (!robot.poseWorld || !onLevel([robot.level])) continue;
    const seconds = site.ageOf(robot.receiveTime, now);
    items.push({ name: robot.name, title: idOf(robot.name), icon: 'robot', tone: seconds > STALE_S ? 'quiet' : 'good', note: seconds > STALE_S ? `${age(seconds)} ago` : 'now' });
  }
  for (const map of [...site.maps.values()].sort((a, b) => byName(a.displayName, b.displayName))) {
    if (!map.poseWorldMap || !onLevel([map.level]) || !shows(map.map)) continue;
    items.push({ name: map.map, title: map.displayName, icon: 'map', tone: 'good', note: map.map === site.rootMap ? 'root' : '' });
  }
  for (const point of site.linkPoints.values()) {
    if (!point.poseWorldPlace || !onLevel(levelsOf(site, point)) || !shows(point.linkPoint)) continue;
    const { tone, text } = stateOf(point);
    items.push({ name: point.linkPoint, title: titleOf(site, point.linkPoint), icon: 'link', tone, note: text.split(':')[0]! });
  }
  return items;
}

// Long sites: what does not fit is found by search.
const SHOWN = 300;

// All that the canvas shows (undefined: there is no canvas, so all that there is), for who does not see it: arrow keys move, Enter selects.
export function ObjectList({ level }: { level: number | undefined }) {
  const site = useLive();
  const selected = useSelection();
  const now = useNow();
  const inView = useInView();
  const [activeName, setActiveName] = useState<string>();
  const list = useRef<HTMLUListElement>(null);
  const items = useMemo(() => itemsOf(site, level, now, inView), [site, level, now, inView]);
  const shown = items.slice(0, SHOWN);
  // What comes and goes around it does not change which one is active.
  const active = Math.max(0, shown.findIndex(({ name }) => name === activeName));

  const onKeyDown = (event: KeyboardEvent) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step !== undefined) {
      event.preventDefault();
      const next = Math.min(shown.length - 1, Math.max(0, active + step));
      setActiveName(shown[next]?.name);
      list.current?.children[next]?.scrollIntoView({ block: 'nearest' });
    } else if (event.key === 'Enter' && shown[active]) {
      select(shown[active].name);
    }
  };
  return (
    <section className="objects" aria-label="Objects in view">
      <h2>
        In view <span className="sub">{count(items.length, 'object')}</span>
      </h2>
      <ul ref={list} role="listbox" aria-label="Objects in view" tabIndex={0} onKeyDown={onKeyDown} aria-activedescendant={shown[active] && `object-${active}`}>
        {shown.map((item, i) => (
          <li key={item.name} id={`object-${i}`} role="option" aria-selected={item.name === selected} className={i === active ? 'object active' : 'object'} onClick={() => { setActiveName(item.name); select(item.name); }}>
            <Icon name={item.icon} />
            <span className="object-title">{item.title}</span>
            {item.note !== '' && <Badge tone={item.tone}>{item.note}</Badge>}
          </li>
        ))}
      </ul>
      {items.length > SHOWN && <p className="sub">The first {SHOWN} are listed. Zoom in, or press / to search all.</p>}
    </section>
  );
}

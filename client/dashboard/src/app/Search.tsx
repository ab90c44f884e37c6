// SPDX-License-Identifier: Apache-2.0
import { useEffect, useId, useMemo, useRef, useState, type KeyboardEvent } from 'react';
import { idOf } from '../api/names';
import { useLive } from '../live/context';
import { titleOf } from '../live/objects';
import type { LiveSite } from '../live/site';
import { Icon, type IconName } from '../ui/Icon';
import { pages } from './pages';
import { addressOf, navigate, usePlace } from './router';
import { onCampus } from './selection';

interface Hit {
  key: string;
  icon: IconName;
  title: string;
  kind: string;
  address: string;
}

const LIMIT = 12;

function hitsOf(site: LiveSite): Hit[] {
  const hits: Hit[] = pages.map(({ path, title, icon }) => ({ key: path, icon, title, kind: 'Page', address: addressOf(site.id, path) }));
  for (const name of site.robots.names) {
    const level = site.robots.get(name)?.level;
    hits.push({ key: name, icon: 'robot', title: idOf(name), kind: 'Robot', address: onCampus(site.id, name, level) });
  }
  for (const map of site.maps.values()) {
    hits.push({ key: map.map, icon: 'map', title: map.displayName, kind: 'Map', address: onCampus(site.id, map.map, map.level) });
  }
  for (const name of site.linkPoints.keys()) {
    hits.push({ key: name, icon: 'link', title: titleOf(site, name), kind: idOf(name).slice(0, 8), address: onCampus(site.id, name) });
  }
  return hits;
}

// Those whose title begins with the text first, then those that contain it.
export function matching<T extends { title: string }>(hits: T[], text: string, limit: number): T[] {
  const wanted = text.trim().toLowerCase();
  const found = hits.filter(({ title }) => title.toLowerCase().includes(wanted));
  const first = (hit: T) => (hit.title.toLowerCase().startsWith(wanted) ? 0 : 1);
  return found.sort((a, b) => first(a) - first(b)).slice(0, limit);
}

function SearchBox({ close }: { close: () => void }) {
  const site = useLive();
  const [text, setText] = useState('');
  const [active, setActive] = useState(0);
  const hits = useMemo(() => matching(hitsOf(site), text, LIMIT), [site, text]);
  const id = useId();

  const go = (hit: Hit | undefined) => {
    if (!hit) return;
    navigate(hit.address);
    close();
  };
  const onKeyDown = (event: KeyboardEvent) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step !== undefined && hits.length > 0) {
      event.preventDefault();
      setActive((active + step + hits.length) % hits.length);
    } else if (event.key === 'Enter') {
      go(hits[active]);
    }
  };
  return (
    <>
      <div className="search-head">
        <Icon name="search" />
        <input
          autoFocus className="search-input" placeholder="Robots, maps, link points, pages" value={text} onKeyDown={onKeyDown}
          role="combobox" aria-label="Search" aria-expanded="true" aria-controls={id} aria-autocomplete="list"
          aria-activedescendant={hits[active] && `${id}-${active}`}
          onChange={(event) => {
            setText(event.target.value);
            setActive(0);
          }}
        />
        <kbd>Esc</kbd>
      </div>
      <div className="search-hits" role="listbox" id={id} aria-label="Results">
        {hits.map((hit, i) => (
          <div key={hit.key} id={`${id}-${i}`} role="option" aria-selected={i === active} className="search-hit" onPointerMove={() => setActive(i)} onClick={() => go(hit)}>
            <Icon name={hit.icon} />
            <span className="search-title">{hit.title}</span>
            <span className="search-kind">{hit.kind}</span>
          </div>
        ))}
      </div>
      {hits.length === 0 && <p className="search-none">Nothing here is called “{text}”. Search finds what this site has now, by its name.</p>}
    </>
  );
}

const isTyping = (target: EventTarget | null) => target instanceof HTMLElement && target.closest('input, select, textarea, [contenteditable]') !== null;

export function Search() {
  const dialog = useRef<HTMLDialogElement>(null);
  const [open, setOpen] = useState(false);
  const { site } = usePlace();

  useEffect(() => {
    const onKeyDown = (event: globalThis.KeyboardEvent) => {
      if (event.key !== '/' || event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target)) return;
      event.preventDefault();
      setOpen(true);
    };
    window.addEventListener('keydown', onKeyDown);
    return () => window.removeEventListener('keydown', onKeyDown);
  }, [site]);
  useEffect(() => {
    if (open) dialog.current?.showModal();
    else dialog.current?.close();
  }, [open]);

  return (
    <>
      <button className="button search-button" onClick={() => setOpen(true)} aria-label="Search" aria-keyshortcuts="/">
        <Icon name="search" />
        <span className="label">Search</span>
        <kbd>/</kbd>
      </button>
      <dialog ref={dialog} className="search" aria-label="Search" onClose={() => setOpen(false)} onClick={(event) => event.target === dialog.current && setOpen(false)}>
        {open && <SearchBox close={() => setOpen(false)} />}
      </dialog>
    </>
  );
}

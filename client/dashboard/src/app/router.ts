// SPDX-License-Identifier: Apache-2.0
// Addresses: /s/SITE/PAGE[/REST]?l=LEVEL&sel=maps/hall&v=X,Y,SCALE. What is selected is in the address, so that it can be
// sent to somebody else, and survives a reload.
import { createElement, useSyncExternalStore, type ComponentProps, type MouseEvent } from 'react';
import { Signal } from '../signal';

export interface Place {
  site?: string;
  page: string;
  // What follows the page, for example a map's id.
  rest: string[];
  query: URLSearchParams;
}

export function parsePlace(path: string, search: string): Place {
  const [s, site, page, ...rest] = path.split('/').filter((part) => part !== '').map(decodeURIComponent);
  const query = new URLSearchParams(search);
  if (s !== 's' || site === undefined) return { page: '', rest: [], query };
  return { site, page: page ?? 'campus', rest, query };
}

export function addressOf(site: string, page: string, rest: string[] = [], query: Record<string, string | undefined> = {}): string {
  const path = ['s', site, page, ...rest].map(encodeURIComponent).join('/');
  const search = Object.entries(query)
    .filter((entry): entry is [string, string] => entry[1] !== undefined && entry[1] !== '')
    .map(([key, value]) => `${key}=${encodeURIComponent(value).replace(/%2F/g, '/').replace(/%2C/g, ',')}`)
    .join('&');
  return `/${path}${search === '' ? '' : `?${search}`}`;
}

const changed = new Signal();
let place = parsePlace(location.pathname, location.search);

function moved() {
  place = parsePlace(location.pathname, location.search);
  changed.tell();
}

window.addEventListener('popstate', moved);

export function navigate(address: string, how: 'push' | 'replace' = 'push') {
  if (address === location.pathname + location.search) return;
  history[how === 'push' ? 'pushState' : 'replaceState'](null, '', address);
  moved();
}

// Changes parts of the query and keeps the rest; undefined removes.
export function setQuery(changes: Record<string, string | undefined>, how: 'push' | 'replace' = 'replace') {
  const query = { ...Object.fromEntries(place.query), ...changes };
  if (place.site !== undefined) navigate(addressOf(place.site, place.page, place.rest, query), how);
}

export const currentPlace = () => place;

export const usePlace = (): Place => useSyncExternalStore(changed.subscribe, () => place);

// A link within the dashboard.
export function Link({ href, ...rest }: ComponentProps<'a'> & { href: string }) {
  const onClick = (event: MouseEvent<HTMLAnchorElement>) => {
    rest.onClick?.(event);
    if (event.defaultPrevented || event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
    event.preventDefault();
    navigate(href);
  };
  return createElement('a', { ...rest, href, onClick });
}

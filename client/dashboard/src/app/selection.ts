// SPDX-License-Identifier: Apache-2.0
import { withSite, withoutSite } from '../api/names';
import { addressOf, setQuery, usePlace } from './router';

// The selected resource, by its whole name.
export function useSelection(): string | undefined {
  const { site, query } = usePlace();
  const selected = query.get('sel');
  return site !== undefined && selected ? withSite(site, selected) : undefined;
}

export const select = (name: string | undefined) => setQuery({ sel: name && withoutSite(name) });

// The level that is shown; undefined: all.
export function useLevel(): number | undefined {
  const text = usePlace().query.get('l');
  return text !== null && /^-?\d+$/.test(text) ? Number(text) : undefined;
}

export const setLevel = (level: number | undefined) => setQuery({ l: level?.toString() });

// Where the campus shows a resource.
export const onCampus = (site: string, name: string, level?: number) =>
  addressOf(site, 'campus', [], { l: level?.toString(), sel: withoutSite(name) });

// Where its link points are changed.
export const inEditor = (site: string, name: string) => addressOf(site, 'campus', [], { sel: withoutSite(name), edit: 'graph' });

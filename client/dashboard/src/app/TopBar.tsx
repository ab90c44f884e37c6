// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { collect, sites } from '../api/clients';
import { idOf } from '../api/names';
import { useLive } from '../live/context';
import { levelName } from '../ui/format';
import { Appearance } from './Appearance';
import { addressOf, navigate, usePlace } from './router';
import { Search } from './Search';
import { setLevel, useLevel } from './selection';
import { StreamBadge } from './StreamNotice';

export const useSites = () =>
  useQuery({
    queryKey: ['sites'],
    queryFn: () => collect(async (pageToken) => {
      const { sites: items, nextPageToken } = await sites.listSites({ pageSize: 1000, pageToken });
      return [items, nextPageToken];
    }),
  });

function SiteSelect() {
  const { site, page } = usePlace();
  const { data = [] } = useSites();
  const known = data.map(({ name, displayName }) => [idOf(name), displayName] as const);
  if (site !== undefined && !known.some(([id]) => id === site)) known.unshift([site, site]);
  return (
    <select className="select" aria-label="Site" value={site ?? ''} onChange={(event) => navigate(addressOf(event.target.value, page || 'campus'))}>
      {site === undefined && <option value="">Choose a site</option>}
      {known.map(([id, title]) => (
        <option key={id} value={id}>
          {title}
        </option>
      ))}
    </select>
  );
}

function LevelSelect() {
  const levels = useLive().levels();
  const level = useLevel();
  if (levels.length < 2 && level === undefined) return null;
  const choices = level !== undefined && !levels.includes(level) ? [...levels, level] : levels;
  return (
    <select className="select" aria-label="Level" value={level ?? ''} onChange={(event) => setLevel(event.target.value === '' ? undefined : Number(event.target.value))}>
      <option value="">All levels</option>
      {choices.map((value) => (
        <option key={value} value={value}>
          {levelName(value)}
        </option>
      ))}
    </select>
  );
}

export function TopBar({ live }: { live: boolean }) {
  return (
    <header className="bar">
      <SiteSelect />
      {live && <LevelSelect />}
      <span className="space" />
      {live && <Search />}
      {live && <StreamBadge />}
      <Appearance />
    </header>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { createContext, useContext, useEffect, useState, useSyncExternalStore } from 'react';
import { LiveSite } from './site';
import { watchSite } from './stream';

export const LiveContext = createContext<LiveSite | undefined>(undefined);

// The live state of the site of the page, as of the last change: the component is drawn again at most four times a second.
export function useLive(): LiveSite {
  const site = useContext(LiveContext);
  if (!site) throw new Error('this page has no site');
  useSyncExternalStore(site.subscribe, site.snapshot);
  return site;
}

// One stream for as long as the component shows the site.
export function useLiveSite(id: string | undefined): LiveSite | undefined {
  const [site, setSite] = useState<LiveSite>();
  useEffect(() => {
    if (id === undefined) return setSite(undefined);
    const live = new LiveSite(id);
    setSite(live);
    return watchSite(live);
  }, [id]);
  return site?.id === id ? site : undefined;
}

// The time, told each `periodMs`: for ages.
export function useNow(periodMs = 1000): number {
  const [now, setNow] = useState(Date.now);
  useEffect(() => {
    const timer = setInterval(() => setNow(Date.now()), periodMs);
    return () => clearInterval(timer);
  }, [periodMs]);
  return now;
}

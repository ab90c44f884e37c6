// SPDX-License-Identifier: Apache-2.0
import { Suspense, type ReactNode } from 'react';
import { LiveContext, useLive, useLiveSite } from '../live/context';
import { Icon } from '../ui/Icon';
import { Empty, Failed, Loading } from '../ui/States';
import { pages } from './pages';
import { addressOf, Link, usePlace } from './router';
import { StreamNotice } from './StreamNotice';
import { TopBar } from './TopBar';

function RailCount({ count }: { count: (site: ReturnType<typeof useLive>) => number }) {
  const n = count(useLive());
  return n > 0 ? <span className="count">{n}</span> : null;
}

function Rail({ site, live }: { site: string | undefined; live: boolean }) {
  const { page, query } = usePlace();
  const kept = { l: query.get('l') ?? undefined, sel: query.get('sel') ?? undefined };
  return (
    <nav className="rail" aria-label="Pages">
      <Link className="brand" href="/">
        <img src="/icon.svg" alt="" />
        <span className="label">Enfilade</span>
      </Link>
      {site !== undefined &&
        pages.map(({ path, title, icon, count }) => (
          <Link key={path} className="rail-link" href={addressOf(site, path, [], kept)} aria-current={page === path ? 'page' : undefined} title={title}>
            <Icon name={icon} />
            <span className="label">{title}</span>
            {live && count && <RailCount count={count} />}
          </Link>
        ))}
    </nav>
  );
}

function Content() {
  const live = useLive();
  const { page } = usePlace();
  const found = pages.find(({ path }) => path === page);
  if (live.state.kind === 'refused') return <Failed error={live.state.error} />;
  if (live.state.kind === 'lost' && !live.complete) {
    return (
      <Empty title="The site cannot be loaded" command="enfilade server status">
        {`The gateway says: ${live.state.reason}. This page tries again by itself. On the computer of the server, ask how it is:`}
      </Empty>
    );
  }
  if (!found) return <Empty title="There is no such page">The address names the page “{page}”. Choose one on the left.</Empty>;
  const Component = found.component;
  return (
    <Suspense fallback={<Loading />}>
      <h1 className="hidden-text">{found.title}</h1>
      <Component />
    </Suspense>
  );
}

// Rail, bar and the page of a site; `children` instead of the page where there is no site.
export function Shell({ children }: { children?: ReactNode }) {
  const { site } = usePlace();
  const live = useLiveSite(site);
  const frame = (
    <div className="shell">
      <a className="skip button" href="#main">
        Skip to content
      </a>
      <Rail site={site} live={live !== undefined} />
      <TopBar live={live !== undefined} />
      {live && <StreamNotice />}
      <main className="main" id="main" tabIndex={-1}>
        {children ?? (live ? <Content key={site} /> : <Loading />)}
      </main>
    </div>
  );
  return <LiveContext value={live}>{frame}</LiveContext>;
}

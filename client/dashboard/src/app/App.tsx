// SPDX-License-Identifier: Apache-2.0
import { useEffect } from 'react';
import { idOf } from '../api/names';
import { Empty, Failed, Loading } from '../ui/States';
import { pages } from './pages';
import { addressOf, Link, navigate, usePlace } from './router';
import { Shell } from './Shell';
import { useSites } from './TopBar';

// Where no site is chosen: the list of sites, or the only one at once.
function Sites() {
  const { data, error, refetch } = useSites();
  const only = data?.length === 1 ? data[0] : undefined;
  useEffect(() => {
    if (only) navigate(addressOf(idOf(only.name), 'campus'), 'replace');
  }, [only]);
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  if (!data || only) return <Loading />;
  if (data.length === 0) {
    return (
      <Empty title="No sites yet" command="enfilade site create demo --name Demonstration">
        A site is one campus with its maps and robots. Create one; it appears here when you load this page again.
      </Empty>
    );
  }
  return (
    <div className="page">
      <div className="page-head">
        <h1>Sites</h1>
      </div>
      <div className="card table-scroll">
        <table className="table">
          <thead>
            <tr>
              <th>Name</th>
              <th>Id</th>
            </tr>
          </thead>
          <tbody>
            {data.map(({ name, displayName }) => (
              <tr key={name}>
                <td>
                  <Link href={addressOf(idOf(name), 'campus')}>{displayName}</Link>
                </td>
                <td className="mono">{idOf(name)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </div>
  );
}

export function App() {
  const { site, page } = usePlace();
  useEffect(() => {
    const title = pages.find(({ path }) => path === page)?.title;
    document.title = [title, site, 'Enfilade'].filter(Boolean).join(' · ');
  }, [site, page]);
  return <Shell>{site === undefined ? <Sites /> : undefined}</Shell>;
}

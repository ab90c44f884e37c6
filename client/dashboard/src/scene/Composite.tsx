// SPDX-License-Identifier: Apache-2.0
import { useLive } from '../live/context';
import { Empty } from '../ui/States';
import type { View } from './model';

// What a browser shows that has no WebGL2: of a campus the server's picture, and what else works.
export function Composite({ view }: { view: View }) {
  const live = useLive();
  const why =
    'Drawing the map needs WebGL2, which this browser does not have or has switched off. The lists on this page work without it; another browser, or hardware acceleration in the settings of this one, brings the map back.';
  const isShown = view.map === undefined && live.rasters.size > 0;
  if (!isShown) return <Empty title="This browser cannot draw the map">{why}</Empty>;
  // The last two are for the browser, which asks for a picture anew only at another address.
  const query = new URLSearchParams({ width: '1024', palette: 'nav2', graph: String(live.graphVersion), rasters: String(live.rasterRevision) });
  if (view.level !== undefined) query.set('level', String(view.level));
  return (
    <figure className="composite">
      <img src={`/v1/sites/${live.id}/composite.png?${query}`} alt="All maps of the level as the graph places them, walls in black" />
      <figcaption>This is a picture from the server. {why}</figcaption>
    </figure>
  );
}

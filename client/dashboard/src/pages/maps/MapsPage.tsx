// SPDX-License-Identifier: Apache-2.0
import { lazy } from 'react';
import { idOf } from '../../api/names';
import { addressOf, Link, setQuery, usePlace } from '../../app/router';
import { onCampus, useLevel } from '../../app/selection';
import { useLive } from '../../live/context';
import { Badge } from '../../ui/Badge';
import { byName, dateTime, levelName } from '../../ui/format';
import { Empty, Loading } from '../../ui/States';
import { ImportForm } from './ImportForm';
import { MapPage } from './MapPage';

// Few who look at maps edit them.
const EditPage = lazy(() => import('../edit/EditPage'));

function MapTable() {
  const live = useLive();
  const level = useLevel();
  const maps = [...live.maps.values()]
    .filter((map) => level === undefined || map.level === level)
    .sort((a, b) => a.level - b.level || byName(a.displayName, b.displayName));
  if (!live.complete) return <Loading />;
  if (maps.length === 0) {
    return (
      <Empty title={level === undefined ? 'No maps yet' : 'No maps on this level'} command={`enfilade --site ${live.id} robot --robot r1 --campus figure1 --map Hall`}>
        A map is one room, corridor or outdoor area. Robots make them as they drive; files of other programs are imported here or
        by “enfilade map import”.
      </Empty>
    );
  }
  return (
    <div className="card table-scroll">
      <table className="table">
        <thead>
          <tr>
            <th>Name</th>
            <th>Level</th>
            <th>Place</th>
            <th>Newest revision</th>
            <th>Made</th>
          </tr>
        </thead>
        <tbody>
          {maps.map((map) => {
            const raster = live.rasters.get(map.map);
            return (
              <tr key={map.map}>
                <td>
                  <Link href={addressOf(live.id, 'maps', [idOf(map.map)])}>{map.displayName}</Link>
                </td>
                <td>{levelName(map.level)}</td>
                <td>
                  {map.poseWorldMap ? (
                    <Link href={onCampus(live.id, map.map, map.level)}>
                      <Badge tone="good">{map.map === live.rootMap ? 'Root of the world frame' : 'Joined to the root'}</Badge>
                    </Link>
                  ) : (
                    <Badge tone="warn">Not joined to the root</Badge>
                  )}
                </td>
                <td>{raster ? idOf(raster.revision) : <span className="sub">none yet</span>}</td>
                <td>{raster?.createTime ? dateTime(raster.createTime) : ''}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

export default function MapsPage() {
  const { rest, query } = usePlace();
  const isImporting = query.has('import');
  if (rest[0] !== undefined && rest[1] === 'edit') return <EditPage map={rest[0]} draft={rest[2]} />;
  if (rest[0] !== undefined) return <MapPage id={rest[0]} />;
  return (
    <div className="page">
      <div className="page-head">
        <h1>Maps</h1>
        <span className="space" />
        <button className="button" aria-expanded={isImporting} onClick={() => setQuery({ import: isImporting ? undefined : '1' })}>
          Import a map
        </button>
      </div>
      {isImporting && <ImportForm />}
      <MapTable />
    </div>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { useState } from 'react';
import { mapAreas } from '../../api/clients';
import { problemOf } from '../../api/errors';
import type { MapArea } from '../../gen/enfilade/v1/map_area_pb';
import { areasKey } from '../../live/areas';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { FileLinks, filesAt } from '../../ui/FileLinks';
import { refusalOf } from '../../ui/Sending';
import { areaText } from './areas';

const formats = [
  ['geojson', 'GeoJSON, all areas'],
  ['nav2-keepout', 'Keep-out mask, for Nav2'],
  ['nav2-speed', 'Speed mask, for Nav2'],
] as const;

// The etag is that of what the person sees: an area that somebody else has changed meanwhile is left as it is. A second
// button, so that nothing is deleted by one click.
function AreaItem({ area, map }: { area: MapArea; map: string }) {
  const queries = useQueryClient();
  const [isAsking, setAsking] = useState(false);
  const { mutate, error, isPending } = useMutation({
    mutationFn: () => mapAreas.deleteMapArea({ name: area.name, etag: area.etag }),
    onSettled: () => queries.invalidateQueries({ queryKey: areasKey(map) }),
  });
  return (
    <li className="area">
      <div className="object">
        <span className="object-title">{area.displayName}</span>
        {isAsking ? (
          <span className="area-question" role="group" aria-label={`Delete ${area.displayName}?`}>
            <button className="button small-text" autoFocus onClick={() => setAsking(false)}>
              Keep it
            </button>
            <button className="button small-text" disabled={isPending} onClick={() => mutate()}>
              Delete it
            </button>
          </span>
        ) : (
          <button className="button small-text" aria-label={`Delete ${area.displayName}`} onClick={() => setAsking(true)}>
            Delete
          </button>
        )}
      </div>
      <p className="sub">{areaText(area)}</p>
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
    </li>
  );
}

// The server makes the files when they are asked for. They change with the areas: they are listed anew each time.
function AreaFormat({ map, format, title, state }: { map: string; format: string; title: string; state: string }) {
  const [open, setOpen] = useState(false);
  const { data, error, isFetching } = useQuery({
    queryKey: ['areaFiles', map, format, state],
    enabled: open,
    queryFn: () => filesAt(`/v1/${map}/areas/files?format=${format}`),
  });
  return (
    <details className="download" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {isFetching && <p className="sub">Making the files …</p>}
      {error && <p className="sub">{problemOf(error).text}</p>}
      <FileLinks files={data} />
    </details>
  );
}

export function Areas({ map, areas }: { map: string; areas: MapArea[] }) {
  const live = useLive();
  return (
    <section className="areas">
      <h2>
        Areas <span className="sub">{areas.length}</span>
      </h2>
      {areas.length === 0 && (
        <p className="sub">
          None. Add one: <code>{`enfilade --site ${live.id} area add "${titleOf(live, map)}" --kind keep-out --polygon "0,0 4,0 4,2"`}</code>
        </p>
      )}
      <ul className="link-list">
        {areas.map((area) => (
          <AreaItem key={area.name} area={area} map={map} />
        ))}
      </ul>
      {areas.length > 0 &&
        formats.map(([format, title]) => (
          <AreaFormat key={format} map={map} format={format} title={title} state={areas.map(({ etag }) => etag).join()} />
        ))}
    </section>
  );
}

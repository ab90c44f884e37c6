// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { useEffect, useState } from 'react';
import { collect, mapAreas } from '../../api/clients';
import { united, UNITS } from '../../edit/lattice';
import type { MapArea } from '../../gen/enfilade/v1/map_area_pb';
import { refusalOf } from '../../ui/Sending';
import { AreaForm, kindNames } from './AreaForm';
import { Sure } from './Sure';
import type { EditorState } from './useEditor';

const POLL_MS = 15_000;
const areasKey = (map: string) => ['areas', map];

function useAreas(map: string) {
  return useQuery({
    queryKey: areasKey(map),
    refetchInterval: POLL_MS,
    queryFn: () => collect(async (pageToken) => {
      const { areas, nextPageToken } = await mapAreas.listMapAreas({ parent: map, pageSize: 1000, pageToken });
      return [areas, nextPageToken];
    }),
  });
}

function Rename({ area, done }: { area: MapArea; done: () => void }) {
  const [title, setTitle] = useState(area.displayName);
  const { mutate, error, isPending } = useMutation({
    mutationFn: () => mapAreas.updateMapArea({ area: { name: area.name, displayName: title.trim(), etag: area.etag }, updateMask: { paths: ['display_name'] } }),
    onSuccess: done,
  });
  return (
    <form className="edit-settle" aria-label={`Rename ${area.displayName}`} noValidate onSubmit={(event) => { event.preventDefault(); mutate(); }}>
      <label>
        New name
        <input className="field" autoFocus maxLength={200} value={title} onChange={(event) => setTitle(event.target.value)} />
      </label>
      <button className="button" disabled={isPending || title.trim() === ''}>
        Rename
      </button>
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
    </form>
  );
}

interface RowProps {
  area: MapArea;
  isSelected: boolean;
  select: () => void;
  changed: () => void;
}

function Row({ area, isSelected, select, changed }: RowProps) {
  const [isRenaming, setRenaming] = useState(false);
  const { mutate, error, isPending } = useMutation({ mutationFn: () => mapAreas.deleteMapArea({ name: area.name, etag: area.etag }), onSettled: changed });
  const types = area.robotTypes.length === 0 ? 'all robots' : area.robotTypes.join(', ');
  return (
    <li className="edit-item">
      <button className="object" aria-pressed={isSelected} onClick={select}>
        <span className="object-title">{area.displayName}</span>
        <span className="sub">
          {kindNames[area.kind]}
          {area.speedLimitMps > 0 && ` ${area.speedLimitMps} m/s`}, {types}
        </span>
      </button>
      {isSelected && (
        <div className="edit-choices">
          <button className="button" onClick={() => setRenaming(!isRenaming)}>
            Rename
          </button>
          <Sure title="Delete" question={`Delete “${area.displayName}”?`} keep="Keep it" act="Delete it" busy={isPending} onAct={() => mutate()} />
        </div>
      )}
      {isRenaming && <Rename area={area} done={() => { setRenaming(false); changed(); }} />}
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
    </li>
  );
}

// Parts of the map with a meaning. They are stored at once, not with the draft.
export function Areas({ editor, map }: { editor: EditorState; map: string }) {
  const { board, session } = editor;
  const queries = useQueryClient();
  const { data = [], error } = useAreas(map);
  const [selected, setSelected] = useState<string>();
  const [isAdding, setAdding] = useState(false);
  const changed = () => void queries.invalidateQueries({ queryKey: areasKey(map) });
  useEffect(() => {
    board.outlines = data.map(({ name, displayName, outline }) => ({ name: displayName, isSelected: name === selected, corners: (outline?.corners ?? []).map(session.frame.cells) }));
    board.touch();
  }, [board, session, data, selected]);

  const select = ({ name, outline }: MapArea) => {
    setSelected(name === selected ? undefined : name);
    if (name === selected || !outline) return;
    const box = outline.corners.map(session.frame.cells).map(({ x, y }) => ({ firstColumn: Math.floor(x), firstRow: Math.floor(y), width: 1, height: 1 })).reduce(united);
    board.fit(box);
  };
  const { ring } = editor;
  const drawn = ring?.map(({ x, y }) => session.frame.metres({ x: x / UNITS, y: y / UNITS }));
  const end = () => {
    setAdding(false);
    editor.set({ ring: undefined });
  };
  return (
    <section className="inspector-part" aria-label="Areas">
      <h2>
        Areas <span className="sub">{data.length}</span>
      </h2>
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
      <ul>
        {data.map((area) => (
          <Row key={area.name} area={area} isSelected={area.name === selected} select={() => select(area)} changed={changed} />
        ))}
      </ul>
      {isAdding || drawn ? (
        <AreaForm key={JSON.stringify(drawn)} map={map} corners={drawn} done={() => { end(); changed(); }} cancel={end} />
      ) : (
        <p className="edit-line">
          <span className="sub">Draw its outline with the tool Area, or enter its corners.</span>
          <button className="button small-text" onClick={() => setAdding(true)}>
            New area
          </button>
        </p>
      )}
    </section>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useEffect, useState } from 'react';
import { mapAreas } from '../../api/clients';
import { united } from '../../edit/lattice';
import type { MapArea } from '../../gen/enfilade/v1/map_area_pb';
import { areasKey, useAreas } from '../../live/areas';
import { refusalOf } from '../../ui/Sending';
import { areaText } from '../maps/areas';
import { AreaForm } from './AreaForm';
import { Sure } from './Sure';
import type { EditorState } from './useEditor';

const POLL_MS = 15_000;

interface RowProps {
  area: MapArea;
  isSelected: boolean;
  select: () => void;
  // Undefined: another one is edited.
  edit: (() => void) | undefined;
  changed: () => void;
}

function Row({ area, isSelected, select, edit, changed }: RowProps) {
  const { mutate, error, isPending } = useMutation({ mutationFn: () => mapAreas.deleteMapArea({ name: area.name, etag: area.etag }), onSettled: changed });
  return (
    <li className="edit-item">
      <button className="object" aria-pressed={isSelected} onClick={select}>
        <span className="object-title">{area.displayName}</span>
        <span className="sub">{areaText(area)}</span>
      </button>
      {isSelected && edit && (
        <div className="edit-choices">
          <button className="button" onClick={edit}>
            Edit
          </button>
          <Sure title="Delete" question={`Delete “${area.displayName}”?`} keep="Keep it" act="Delete it" busy={isPending} onAct={() => mutate()} />
        </div>
      )}
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
    </li>
  );
}

// What the form is for.
interface Open {
  // Undefined: a new one.
  area: MapArea | undefined;
}

// Parts of the map with a meaning. They are stored at once, not with the draft.
export function Areas({ editor, map }: { editor: EditorState; map: string }) {
  const { board, session, outline } = editor;
  const queries = useQueryClient();
  const { data = [], error } = useAreas(map, POLL_MS);
  const [selected, setSelected] = useState<string>();
  const [opened, setOpened] = useState<Open>();
  // Who draws an outline wants an area.
  const open = opened ?? (outline && { area: undefined });
  const changed = () => void queries.invalidateQueries({ queryKey: areasKey(map) });
  useEffect(() => {
    const shown = data.filter(({ name }) => !outline || name !== open?.area?.name).map((area) => ({ name: area.displayName, isSelected: area.name === selected, corners: (area.outline?.corners ?? []).map(session.frame.cells) }));
    if (outline) shown.push({ name: open?.area?.displayName ?? 'New area', isSelected: true, corners: outline.map(session.frame.cells) });
    board.outlines = shown;
    board.touch();
  }, [board, session, data, selected, outline, open?.area]);

  const select = ({ name, outline: ring }: MapArea) => {
    setSelected(name === selected ? undefined : name);
    if (name === selected || !ring) return;
    const box = ring.corners.map(session.frame.cells).map(({ x, y }) => ({ firstColumn: Math.floor(x), firstRow: Math.floor(y), width: 1, height: 1 })).reduce(united);
    board.fit(box);
  };
  const edit = (area: MapArea) => {
    setOpened({ area });
    editor.set({ outline: (area.outline?.corners ?? []).map(({ x, y }) => ({ x, y })) });
  };
  const end = () => {
    setOpened(undefined);
    editor.set({ outline: undefined });
  };
  return (
    <section className="inspector-part" aria-label="Areas">
      <h2>
        Areas <span className="sub">{data.length}</span>
      </h2>
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
      <ul>
        {data.map((area) => (
          <Row key={area.name} area={area} isSelected={area.name === selected} select={() => select(area)} edit={open ? undefined : () => edit(area)} changed={changed} />
        ))}
      </ul>
      {open ? (
        <AreaForm key={open.area?.name ?? ''} map={map} area={open.area} latest={data.find(({ name }) => name === open.area?.name)} outline={outline} setOutline={(corners) => editor.set({ outline: corners })}
          done={() => { end(); changed(); }} cancel={end} refused={changed} />
      ) : (
        <p className="edit-line">
          <span className="sub">Draw its outline with the tool Area, or enter its corners.</span>
          <button className="button small-text" onClick={() => setOpened({ area: undefined })}>
            New area
          </button>
        </p>
      )}
    </section>
  );
}

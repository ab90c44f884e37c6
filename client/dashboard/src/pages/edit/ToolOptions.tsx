// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { rasters } from '../../api/clients';
import { OCCUPIED, type Value } from '../../edit/cells';
import { valueKeys } from '../../edit/keys';
import { sizes } from '../../edit/tools/settings';
import { classes, thresholdsText, valueNames, values } from '../../edit/words';
import type { EditorState } from './useEditor';

const toggled = (all: Value[], value: Value) => (all.includes(value) ? all.filter((other) => other !== value) : [...all, value]);

// How likely obstacles become cells. It is the same in all revisions of a server.
function Thresholds({ revision }: { revision: string }) {
  const { data } = useQuery({ queryKey: ['thresholds'], enabled: revision !== '', staleTime: Infinity, queryFn: async () => thresholdsText((await rasters.getRasterManifest({ name: revision })).classes) ?? '' });
  return data ? <p className="sub">By what robots see or a file says, a cell counts as {data}. Of an image, the YAML file says how likely a grey is.</p> : null;
}

// What is drawn becomes of the cells, and of which.
export function ToolOptions({ editor: { settings, session } }: { editor: EditorState }) {
  const { value, size, onlyWhere, invisible, isTinted } = settings.get();
  const metres = (cells: number) => `${Number((cells * session.frame.resolution).toPrecision(3))} m`;
  return (
    <section className="inspector-part" aria-label="Drawing">
      <fieldset className="edit-values">
        <legend>Cells become</legend>
        {values.map((one) => (
          <label key={one} title={`Key ${valueKeys[one]}`}>
            <input type="radio" name="value" checked={one === value} onChange={() => settings.set({ value: one })} />
            <i className={`edit-swatch value-${one}`} /> {valueNames[one]} <kbd>{valueKeys[one]}</kbd>
          </label>
        ))}
      </fieldset>
      <label className="edit-line">
        Brush and line, cells across
        <select className="select" value={size} aria-keyshortcuts="[ ]" onChange={(event) => settings.set({ size: Number(event.target.value) })}>
          {sizes.map((one) => (
            <option key={one} value={one}>
              {one} ({metres(one)})
            </option>
          ))}
        </select>
      </label>
      <fieldset className="edit-values">
        <legend>Only cells that are now</legend>
        {classes.map((one) => (
          <label key={one}>
            <input type="checkbox" checked={onlyWhere.includes(one)} onChange={() => settings.set({ onlyWhere: toggled(onlyWhere, one) })} /> {valueNames[one].toLowerCase()}
          </label>
        ))}
        {onlyWhere.length === 0 && <span className="sub">none ticked: all</span>}
      </fieldset>
      <Thresholds revision={session.revision} />
      <label className="edit-line">
        <span>
          <input type="checkbox" checked={invisible} disabled={value !== OCCUPIED} onChange={(event) => settings.set({ invisible: event.target.checked })} /> Invisible to scanners, such as glass
        </span>
      </label>
      <label className="edit-line">
        <span>
          <input type="checkbox" checked={isTinted} onChange={(event) => settings.set({ isTinted: event.target.checked })} /> Colour what this draft changes
        </span>
      </label>
    </section>
  );
}

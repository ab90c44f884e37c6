// SPDX-License-Identifier: Apache-2.0
import { useEffect, useRef, useState, type FormEvent } from 'react';
import { idOf } from '../../api/names';
import type { Progress } from '../../api/upload';
import { addressOf, Link } from '../../app/router';
import { useLevel } from '../../app/selection';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { byName } from '../../ui/format';
import { refusalOf, Sending } from '../../ui/Sending';
import { UploadResult } from '../../ui/UploadResult';
import { importMap, lacking, type Imported } from './importing';

type State =
  | { kind: 'idle' }
  | { kind: 'refused'; text: string }
  | { kind: 'sending'; progress: Progress | undefined; abort: AbortController }
  | { kind: 'done'; imported: Imported };

function Done({ imported: { map, warnings } }: { imported: Imported }) {
  const live = useLive();
  return (
    <UploadResult warnings={warnings}>
      <Link href={addressOf(live.id, 'maps', [idOf(map)])}>{titleOf(live, map)}</Link>
    </UploadResult>
  );
}

// Files of another program become a revision of a map, or a new map.
export function ImportForm() {
  const live = useLive();
  const shownLevel = useLevel();
  const [map, setMap] = useState('');
  const [title, setTitle] = useState('');
  const [level, setLevel] = useState(String(shownLevel ?? 0));
  const [dialect, setDialect] = useState('nav2');
  const [files, setFiles] = useState<File[]>([]);
  const [state, setState] = useState<State>({ kind: 'idle' });
  const running = useRef<AbortController>(undefined);
  // Who leaves the page cancels.
  useEffect(() => () => running.current?.abort(), []);

  const onSubmit = async (event: FormEvent) => {
    event.preventDefault();
    const why = lacking(files) ?? (map === '' && title.trim() === '' ? 'Give the new map a name.' : map === '' && !/^-?\d+$/.test(level) ? 'The level is a whole number; 0 is the ground floor.' : undefined);
    if (why !== undefined) return setState({ kind: 'refused', text: why });
    const abort = new AbortController();
    running.current = abort;
    setState({ kind: 'sending', progress: undefined, abort });
    const what = { ...(map !== '' && { map }), title: title.trim(), level: Number(level), files, dialect };
    try {
      setState({ kind: 'done', imported: await importMap(live.id, what, (progress) => setState({ kind: 'sending', progress, abort }), abort.signal) });
    } catch (error) {
      setState({ kind: 'refused', text: refusalOf(error) });
    }
  };
  const isSending = state.kind === 'sending';
  const known = [...live.maps.values()].sort((a, b) => byName(a.displayName, b.displayName));
  return (
    <form className="card import" aria-label="Import a map" onSubmit={(event) => void onSubmit(event)} noValidate>
      <p className="sub">A map of Nav2 or ROS 1 (a YAML file and its PGM or PNG), or a JSON file as Enfilade exports it.</p>
      <fieldset disabled={isSending}>
        <label>
          Files
          <input type="file" multiple accept=".yaml,.yml,.pgm,.png,.json" onChange={(event) => setFiles([...(event.target.files ?? [])])} />
        </label>
        <label>
          Into
          <select className="select" value={map} onChange={(event) => setMap(event.target.value)}>
            <option value="">a new map</option>
            {known.map((one) => (
              <option key={one.map} value={one.map}>
                {one.displayName}: a new revision
              </option>
            ))}
          </select>
        </label>
        {map === '' && (
          <>
            <label>
              Name
              <input className="field" value={title} maxLength={200} onChange={(event) => setTitle(event.target.value)} />
            </label>
            <label>
              Level
              <input className="field" inputMode="numeric" value={level} onChange={(event) => setLevel(event.target.value)} />
            </label>
          </>
        )}
        <label>
          Thresholds as in
          <select className="select" value={dialect} onChange={(event) => setDialect(event.target.value)}>
            <option value="nav2">Nav2</option>
            <option value="ros1">ROS 1</option>
          </select>
        </label>
      </fieldset>
      {isSending ? <Sending progress={state.progress} cancel={() => state.abort.abort()} /> : <button className="button primary">Import</button>}
      {state.kind === 'refused' && <p className="refusal" role="alert">{state.text}</p>}
      {state.kind === 'done' && <Done imported={state.imported} />}
    </form>
  );
}

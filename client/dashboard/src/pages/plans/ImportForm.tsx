// SPDX-License-Identifier: Apache-2.0
import { useQueryClient } from '@tanstack/react-query';
import { useEffect, useRef, useState, type FormEvent } from 'react';
import { idOf } from '../../api/names';
import type { Progress } from '../../api/upload';
import { addressOf, Link } from '../../app/router';
import { useLevel } from '../../app/selection';
import type { PriorMap } from '../../gen/enfilade/v1/prior_map_pb';
import type { Point } from '../../scene/camera';
import { useLive } from '../../live/context';
import { plansKey } from '../../live/plans';
import { refusalOf, Sending } from '../../ui/Sending';
import { UploadResult } from '../../ui/UploadResult';
import { hasLayers, hasPages, importPlan, isShown, lacking } from './importing';
import { Measure } from './Measure';
import { elementsText } from './plans';

type State =
  | { kind: 'idle' }
  | { kind: 'refused'; text: string }
  | { kind: 'sending'; progress: Progress | undefined; abort: AbortController }
  | { kind: 'done'; plan: PriorMap };

function Done({ plan: { name, displayName, elements, warnings } }: { plan: PriorMap }) {
  const live = useLive();
  return (
    <UploadResult warnings={warnings}>
      <Link href={addressOf(live.id, 'plans', [idOf(name)])}>{displayName}</Link>, {elementsText(elements)}
    </UploadResult>
  );
}

export function ImportForm() {
  const live = useLive();
  const shownLevel = useLevel();
  const queries = useQueryClient();
  const [file, setFile] = useState<File>();
  const [title, setTitle] = useState('');
  const [level, setLevel] = useState(String(shownLevel ?? 0));
  const [page, setPage] = useState('');
  const [layers, setLayers] = useState('');
  const [measure, setMeasure] = useState<Point[]>([]);
  const [metres, setMetres] = useState('');
  const [state, setState] = useState<State>({ kind: 'idle' });
  const running = useRef<AbortController>(undefined);
  // Who leaves the page cancels.
  useEffect(() => () => running.current?.abort(), []);

  const onSubmit = async (event: FormEvent) => {
    event.preventDefault();
    const what = { file, title, level, page, layers, measure, metres };
    const why = lacking(what);
    if (why !== undefined) return setState({ kind: 'refused', text: why });
    const abort = new AbortController();
    running.current = abort;
    setState({ kind: 'sending', progress: undefined, abort });
    try {
      setState({ kind: 'done', plan: await importPlan(live.id, what, (progress) => setState({ kind: 'sending', progress, abort }), abort.signal) });
      await queries.invalidateQueries({ queryKey: plansKey(live.id) });
    } catch (error) {
      setState({ kind: 'refused', text: refusalOf(error) });
    }
  };
  const isSending = state.kind === 'sending';
  return (
    <form className="card import" aria-label="Import a plan" onSubmit={(event) => void onSubmit(event)} noValidate>
      <p className="sub">A floor plan or an emergency plan: PNG, JPEG, PDF, SVG, DXF, GeoJSON, or a building.yaml of Open-RMF.</p>
      <fieldset disabled={isSending}>
        <label>
          File
          <input type="file" accept=".png,.jpg,.jpeg,.pgm,.pdf,.svg,.dxf,.geojson,.json,.yaml,.yml" onChange={(event) => { setFile(event.target.files?.[0]); setMeasure([]); }} />
        </label>
        <label>
          Name
          <input className="field" value={title} maxLength={200} onChange={(event) => setTitle(event.target.value)} />
        </label>
        <label>
          Level
          <input className="field" inputMode="numeric" value={level} onChange={(event) => setLevel(event.target.value)} />
        </label>
        {hasPages(file) && (
          <label>
            Page
            <input className="field" inputMode="numeric" placeholder="the only one" value={page} onChange={(event) => setPage(event.target.value)} />
          </label>
        )}
        {hasLayers(file) && (
          <label>
            Layers
            <input className="field" placeholder="all, or A-WALL*, A-DOOR" value={layers} onChange={(event) => setLayers(event.target.value)} />
          </label>
        )}
        {file && isShown(file) && <Measure file={file} points={measure} show={setMeasure} metres={metres} setMetres={setMetres} />}
      </fieldset>
      {isSending ? <Sending progress={state.progress} cancel={() => state.abort.abort()} /> : <button className="button primary">Import</button>}
      {state.kind === 'refused' && <p className="refusal" role="alert">{state.text}</p>}
      {state.kind === 'done' && <Done plan={state.plan} />}
    </form>
  );
}

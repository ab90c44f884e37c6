// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError } from '@connectrpc/connect';
import { useMutation } from '@tanstack/react-query';
import { useEffect, useRef, useState, type FormEvent } from 'react';
import { mapAreas } from '../../api/clients';
import { changedPaths, cornersText, exactly, fieldsOf, kindNames, kinds, laidOver, messageOf, newFields, problemOf, type AreaFields } from '../../edit/areas';
import { uuid } from '../../edit/ids';
import { parsePoints } from '../../edit/numbers';
import { MapArea_Kind as Kind, type MapArea } from '../../gen/enfilade/v1/map_area_pb';
import type { Point } from '../../scene/camera';
import { refusalOf } from '../../ui/Sending';
import { AreaConflict } from './AreaConflict';

interface CornersProps {
  corners: readonly Point[];
  set: (corners: readonly Point[]) => void;
  // Whether what is typed is no outline.
  wrong: (problem: string) => void;
}

// The outline by numbers, as it is on the map.
function Corners({ corners, set, wrong }: CornersProps) {
  const [text, setText] = useState<string>();
  const typed = useRef(corners);
  useEffect(() => {
    if (corners === typed.current) return;
    typed.current = corners;
    setText(undefined);
    wrong('');
  }, [corners, wrong]);
  const take = (given: string) => {
    setText(given);
    const points = parsePoints(given);
    wrong(typeof points === 'string' ? points : '');
    if (typeof points !== 'string') set((typed.current = exactly(points, corners)));
  };
  return (
    <label className="wide">
      Corners, m
      <textarea className="field" rows={3} placeholder="0, 0; 2, 0; 1, 1.5" value={text ?? cornersText(corners)} onChange={(event) => take(event.target.value)} />
    </label>
  );
}

interface Props {
  map: string;
  // Undefined: a new one.
  area: MapArea | undefined;
  // As it is now; undefined: gone.
  latest: MapArea | undefined;
  outline: readonly Point[] | undefined;
  setOutline: (corners: readonly Point[]) => void;
  // It is stored, or somebody else's is taken.
  done: () => void;
  cancel: () => void;
  // It may not be as it was.
  refused: () => void;
}

const none: readonly Point[] = [];

export function AreaForm({ map, area, latest, outline = none, setOutline, done, cancel, refused }: Props) {
  // What the person's changes are changes of.
  const [base, setBase] = useState(area);
  const before = base ? fieldsOf(base) : newFields;
  const [texts, setTexts] = useState<AreaFields>(before);
  const [problem, setProblem] = useState('');
  const [wrongCorners, setWrongCorners] = useState('');
  const fields = { ...texts, corners: outline };
  const { mutate, error, isPending, reset } = useMutation({
    mutationFn: ({ force }: { force: boolean }): Promise<unknown> => base
      ? mapAreas.updateMapArea({ area: { name: base.name, etag: base.etag, ...messageOf(fields) }, updateMask: { paths: changedPaths(fields, before) }, force })
      : mapAreas.createMapArea({ parent: map, requestId: uuid(), force, area: messageOf(fields) }),
    onSuccess: done,
    onError: refused,
  });
  const set = (changes: Partial<AreaFields>) => {
    setTexts({ ...texts, ...changes });
    setProblem('');
  };
  const submit = (force: boolean) => {
    const found = wrongCorners || (problemOf(fields) ?? '');
    setProblem(found);
    if (found !== '') return;
    if (base && changedPaths(fields, before).length === 0) return done();
    mutate({ force });
  };
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    submit(false);
  };
  const take = (theirs: MapArea | undefined, next: AreaFields) => {
    setBase(theirs);
    setTexts(next);
    setOutline(next.corners);
    reset();
  };
  const isStale = base !== undefined && latest?.etag !== base.etag;
  // A keep-out area over a link point needs a second thought.
  const mayForce = fields.kind === Kind.KEEP_OUT && error !== null && ConnectError.from(error).code === Code.FailedPrecondition;
  const act = base ? 'Save' : 'Create';
  return (
    <form className="edit-numbers" aria-label={base ? `Edit ${base.displayName}` : 'New area'} onSubmit={onSubmit} noValidate>
      <label>
        Kind
        <select className="select" value={fields.kind} onChange={(event) => set({ kind: Number(event.target.value) })}>
          {kinds.map((one) => (
            <option key={one} value={one}>
              {kindNames[one]}
            </option>
          ))}
        </select>
      </label>
      <label>
        Name
        <input className="field" autoFocus maxLength={200} value={fields.title} onChange={(event) => set({ title: event.target.value })} />
      </label>
      {fields.kind === Kind.SPEED_LIMIT && (
        <label className="wide">
          Speed limit, m/s
          <input className="field" inputMode="decimal" value={fields.speed} onChange={(event) => set({ speed: event.target.value })} />
        </label>
      )}
      <label className="wide">
        Robot types
        <input className="field" placeholder="all, or: cleaner, tug" value={fields.types} onChange={(event) => set({ types: event.target.value })} />
      </label>
      {([['from', 'Valid from'], ['until', 'Valid until']] as const).map(([name, label]) => (
        <label key={name} className="wide">
          {label}
          <input className="field" type="datetime-local" step={1} title="In this computer’s time zone. Empty: without an end" value={fields[name]} onChange={(event) => set({ [name]: event.target.value })} />
        </label>
      ))}
      <Corners corners={outline} set={setOutline} wrong={setWrongCorners} />
      <p className="sub wide">Corners can also be dragged on the map; a new outline is drawn with the tool Area.</p>
      {isStale && (
        <div className="wide">
          <AreaConflict before={base} theirs={latest} takeTheirs={() => (latest ? take(latest, fieldsOf(latest)) : cancel())} layMine={(theirs) => take(theirs, laidOver(fields, before, fieldsOf(theirs)))} />
        </div>
      )}
      <div className="actions wide">
        <button className="button primary" disabled={isPending || isStale}>
          {act}
        </button>
        {mayForce && (
          <button className="button" type="button" disabled={isPending} onClick={() => submit(true)}>
            {act} it all the same
          </button>
        )}
        <button className="button" type="button" onClick={cancel}>
          Cancel
        </button>
      </div>
      {problem !== '' && <p className="refusal wide" role="alert">{problem}</p>}
      {error && !isStale && <p className="refusal wide" role="alert">{refusalOf(error)}</p>}
    </form>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { Code, ConnectError } from '@connectrpc/connect';
import { useMutation } from '@tanstack/react-query';
import { useState, type FormEvent } from 'react';
import { mapAreas } from '../../api/clients';
import { uuid } from '../../edit/ids';
import { parsePoints } from '../../edit/numbers';
import { MapArea_Kind as Kind } from '../../gen/enfilade/v1/map_area_pb';
import type { Point } from '../../scene/camera';
import { refusalOf } from '../../ui/Sending';

export const kindNames: Record<Kind, string> = {
  [Kind.UNSPECIFIED]: 'Area', [Kind.KEEP_OUT]: 'Keep out', [Kind.SPEED_LIMIT]: 'Speed limit', [Kind.PREFERRED]: 'Preferred', [Kind.IGNORE_HITS]: 'Ignore hits (mirrors, glass)',
  [Kind.ROOM]: 'Room', [Kind.DOCK]: 'Dock',
};

const kinds = [Kind.KEEP_OUT, Kind.SPEED_LIMIT, Kind.PREFERRED, Kind.IGNORE_HITS, Kind.ROOM, Kind.DOCK];

const textOf = (corners: readonly Point[] = []) => corners.map(({ x, y }) => `${Number(x.toFixed(3))}, ${Number(y.toFixed(3))}`).join('; ');

interface Props {
  map: string;
  // That were drawn, in metres of the map.
  corners: readonly Point[] | undefined;
  done: () => void;
  cancel: () => void;
}

export function AreaForm({ map, corners, done, cancel }: Props) {
  const [kind, setKind] = useState(Kind.KEEP_OUT);
  const [title, setTitle] = useState('');
  const [types, setTypes] = useState('');
  const [speed, setSpeed] = useState('');
  const [outline, setOutline] = useState(textOf(corners));
  const [problem, setProblem] = useState('');
  const { mutate, error, isPending } = useMutation({
    mutationFn: async ({ points, force }: { points: Point[]; force: boolean }) => mapAreas.createMapArea({
      parent: map, requestId: uuid(), force,
      area: {
        displayName: title.trim(), kind, outline: { corners: points }, robotTypes: types.split(/[\s,]+/).filter((type) => type !== ''),
        ...(kind === Kind.SPEED_LIMIT && { speedLimitMps: Number(speed) }),
      },
    }),
    onSuccess: done,
  });
  const submit = (force: boolean) => {
    const points = parsePoints(outline);
    if (title.trim() === '') return setProblem('Enter a name.');
    if (typeof points === 'string') return setProblem(points);
    if (points.length < 3) return setProblem('An area has at least three corners.');
    if (kind === Kind.SPEED_LIMIT && !(Number(speed) > 0)) return setProblem('Enter the speed limit in metres per second, more than 0.');
    setProblem('');
    mutate({ points, force });
  };
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    submit(false);
  };
  // A keep-out area over a link point needs a second thought.
  const mayForce = kind === Kind.KEEP_OUT && error !== null && ConnectError.from(error).code === Code.FailedPrecondition;
  return (
    <form className="edit-numbers" aria-label="New area" onSubmit={onSubmit} noValidate>
      <label>
        Kind
        <select className="select" value={kind} onChange={(event) => setKind(Number(event.target.value))}>
          {kinds.map((one) => (
            <option key={one} value={one}>
              {kindNames[one]}
            </option>
          ))}
        </select>
      </label>
      <label>
        Name
        <input className="field" autoFocus maxLength={200} value={title} onChange={(event) => setTitle(event.target.value)} />
      </label>
      {kind === Kind.SPEED_LIMIT && (
        <label className="wide">
          Speed limit, m/s
          <input className="field" inputMode="decimal" value={speed} onChange={(event) => setSpeed(event.target.value)} />
        </label>
      )}
      <label className="wide">
        Robot types
        <input className="field" placeholder="all, or: cleaner, tug" value={types} onChange={(event) => setTypes(event.target.value)} />
      </label>
      <label className="wide">
        Corners, m
        <input className="field" placeholder="0, 0; 2, 0; 1, 1.5" value={outline} onChange={(event) => setOutline(event.target.value)} />
      </label>
      <div className="actions wide">
        <button className="button primary" disabled={isPending}>
          Create
        </button>
        {mayForce && (
          <button className="button" type="button" disabled={isPending} onClick={() => submit(true)}>
            Create it all the same
          </button>
        )}
        <button className="button" type="button" onClick={cancel}>
          Cancel
        </button>
      </div>
      {problem !== '' && <p className="refusal wide" role="alert">{problem}</p>}
      {error && <p className="refusal wide" role="alert">{refusalOf(error)}</p>}
    </form>
  );
}

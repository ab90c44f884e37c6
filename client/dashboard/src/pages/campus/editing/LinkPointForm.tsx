// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';
import { idOf } from '../../../api/names';
import { kindNames, stateNames } from '../../../graph/differences';
import { anchorsOf, isPinned, isSuspended, movedTo, pinToggled, spreadTo, toggled, withoutAnchor, type Edit } from '../../../graph/draft';
import { LinkPoint_Kind as Kind, LinkPoint_State as State } from '../../../gen/enfilade/v1/link_point_pb';
import { useLive } from '../../../live/context';
import { titleOf } from '../../../live/objects';
import type { Pose } from '../../../scene/camera';
import { byName } from '../../../ui/format';
import { AnchorForm } from './AnchorForm';

interface Props {
  edit: Edit;
  put: (edit: Edit, tag?: string) => void;
  // The map whose anchor is dragged.
  active: string | undefined;
  choose: (map: string) => void;
  // Where the place would be in another map.
  guess: (map: string) => Pose;
}

function Anchors({ edit, put, active, choose }: Omit<Props, 'guess'>) {
  const live = useLive();
  const anchors = anchorsOf(edit);
  const place = active === undefined ? undefined : anchors.get(active);
  return (
    <section className="inspector-part">
      <h2>Anchors</h2>
      <div role="radiogroup" aria-label="Drag in the frame of">
        {[...anchors.keys()].map((map) => (
          <div key={map} className="anchor-choice">
            <label className="choice">
              <input type="radio" name="anchor" checked={map === active} onChange={() => choose(map)} /> {titleOf(live, map)}
            </label>
            {edit.anchors[map] && <span className="sub">changed</span>}
            {!live.maps.get(map)?.poseWorldMap && <span className="sub">not in the world: by numbers only</span>}
            {anchors.size > 1 && (
              <button className="button" aria-label={`Take away the anchor in ${titleOf(live, map)}`} onClick={() => put(withoutAnchor(edit, map))}>
                Take away
              </button>
            )}
          </div>
        ))}
      </div>
      {active !== undefined && place && (
        <AnchorForm key={active} title={titleOf(live, active)} place={place} move={(pose, tag) => put(movedTo(edit, active, pose), tag)} spread={(covariance, tag) => put(spreadTo(edit, active, covariance), tag)} />
      )}
    </section>
  );
}

// Another map in which the place is: makes a link point of a candidate.
function NewAnchor({ edit, put, choose, guess }: Omit<Props, 'active'>) {
  const live = useLive();
  const [map, setMap] = useState('');
  const anchors = anchorsOf(edit);
  const levels = [...anchors.keys()].map((one) => live.maps.get(one)?.level);
  // A lift joins levels, so all are offered; those of its own come first.
  const others = [...live.maps.values()].filter((one) => !anchors.has(one.map)).sort((a, b) => Number(levels.includes(b.level)) - Number(levels.includes(a.level)) || byName(a.displayName, b.displayName));
  if (others.length === 0) return null;
  const add = () => {
    put(movedTo(edit, map, guess(map)));
    choose(map);
    setMap('');
  };
  return (
    <div className="new-anchor">
      <label className="choice">
        {anchors.size === 1 ? 'It leads to' : 'It also leads to'}
        <select className="select" value={map} onChange={(event) => setMap(event.target.value)}>
          <option value="">choose a map</option>
          {others.map((one) => (
            <option key={one.map} value={one.map}>
              {one.displayName}
            </option>
          ))}
        </select>
      </label>
      <button className="button" disabled={map === ''} onClick={add}>
        {anchors.size === 1 ? 'Promote: add the anchor' : 'Add the anchor'}
      </button>
    </div>
  );
}

function Kinds({ edit, put }: Pick<Props, 'edit' | 'put'>) {
  const { base, kind = base.kind, state = base.state } = edit;
  return (
    <div className="numbers">
      <label className="number-field">
        Kind
        <select className="select" value={kind} onChange={(event) => put({ ...edit, kind: Number(event.target.value) })}>
          {[Kind.DOOR, Kind.LIFT, Kind.STAIRS, Kind.RAMP, Kind.OPENING].map((one) => (
            <option key={one} value={one}>
              {kindNames[one]}
            </option>
          ))}
        </select>
      </label>
      <label className="number-field">
        State
        <select className="select" value={state} onChange={(event) => put({ ...edit, state: Number(event.target.value) })}>
          {[State.OPEN, State.CLOSED, State.BLOCKED].map((one) => (
            <option key={one} value={one}>
              {stateNames[one]}
            </option>
          ))}
        </select>
      </label>
    </div>
  );
}

// One link point: its anchors, what it is, and whether the graph uses it.
export function LinkPointForm({ edit, put, active, choose, guess }: Props) {
  const isOff = isSuspended(edit);
  return (
    <>
      {edit.isDeleted ? (
        <p className="refusal">It is deleted with the next save, and its pictures with it.</p>
      ) : (
        <>
          <Anchors edit={edit} put={put} active={active} choose={choose} />
          <NewAnchor edit={edit} put={put} choose={choose} guess={guess} />
          <Kinds edit={edit} put={put} />
          {!edit.isNew && (
            <label className="choice" title="Surveys neither move nor remove what people have placed, until it is unpinned">
              <input type="checkbox" checked={isPinned(edit)} onChange={() => put(pinToggled(edit))} /> Pinned: surveys leave it as it is
            </label>
          )}
        </>
      )}
      <div className="actions">
        {!edit.isNew && !edit.isDeleted && (
          <button className="button" onClick={() => put(toggled(edit))}>
            {isOff ? 'Resume' : 'Suspend'}
          </button>
        )}
        {!edit.isNew && (
          <button className="button" onClick={() => put({ ...edit, isDeleted: !edit.isDeleted })}>
            {edit.isDeleted ? 'Do not delete' : 'Delete'}
          </button>
        )}
      </div>
      <p className="sub mono">{idOf(edit.base.name)}</p>
    </>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';
import { useLive } from '../../../live/context';
import { titleOf } from '../../../live/objects';
import { byName } from '../../../ui/format';
import { MapPin } from './MapPin';
import { MergeForm } from './MergeForm';
import { SplitForm } from './SplitForm';

interface Props {
  map: string;
  // Begins a candidate in the map.
  create: () => void;
  align: (other: string) => void;
  // There are changes of link points that are not saved: those come first.
  isDrafting: boolean;
}

// What can be done with a map: link points of it, how it lies to another one, and what it consists of.
export function MapForm({ map, create, align, isDrafting }: Props) {
  const live = useLive();
  const [other, setOther] = useState('');
  const [asking, setAsking] = useState<'merge' | 'split'>();
  const own = live.maps.get(map);
  const others = [...live.maps.values()].filter((one) => one.map !== map && one.level === own?.level).sort((a, b) => byName(a.displayName, b.displayName));
  const known = others.some((one) => one.map === other);
  return (
    <>
      <div className="actions">
        <button className="button" onClick={create}>
          New link point here
        </button>
        <button className="button" disabled={isDrafting} onClick={() => setAsking('split')}>
          Split …
        </button>
      </div>
      <label className="choice">
        With another map of its level
        <select className="select" value={known ? other : ''} onChange={(event) => setOther(event.target.value)}>
          <option value="">choose a map</option>
          {others.map((one) => (
            <option key={one.map} value={one.map}>
              {one.displayName}
            </option>
          ))}
        </select>
      </label>
      <div className="actions">
        <button className="button" disabled={!known} onClick={() => align(other)}>
          Align
        </button>
        <button className="button" disabled={!known || isDrafting} onClick={() => setAsking('merge')}>
          Merge …
        </button>
      </div>
      {/* A merge or split may have pinned it: it is asked for anew. */}
      {asking === undefined && <MapPin key={map} map={map} />}
      {isDrafting && <p className="sub">Save or discard your changes of link points before you merge or split {titleOf(live, map)}.</p>}
      {asking === 'merge' && known && <MergeForm key={other} into={map} merged={other} pose={undefined} done={() => setAsking(undefined)} />}
      {asking === 'split' && <SplitForm key={map} map={map} done={() => setAsking(undefined)} />}
    </>
  );
}

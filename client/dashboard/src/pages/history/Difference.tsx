// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { setQuery } from '../../app/router';
import { select, useSelection } from '../../app/selection';
import type { GraphVersion } from '../../gen/enfilade/v1/graph_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { count, dateTime, metres, turned } from '../../ui/format';
import { Loading } from '../../ui/States';
import { agreement } from './placings';
import type { Difference as Found, Movement } from './movement';

const stretches = [1, 10, 100, 1000];

interface Props {
  // The oldest first.
  versions: GraphVersion[];
  shown: GraphVersion;
  other: GraphVersion | undefined;
  // Absent while it is read.
  difference: Found | undefined;
  // Of maps that have a place.
  count: number;
  stretch: number;
  setStretch: (factor: number) => void;
}

function Facts({ shown, count: placed }: Pick<Props, 'shown' | 'count'>) {
  const live = useLive();
  return (
    <section>
      <h2>Version {String(shown.graphVersion)}</h2>
      <dl className="facts">
        <dt>Made</dt>
        <dd>{shown.createTime && dateTime(timestampMs(shown.createTime))}</dd>
        <dt>Maps placed</dt>
        <dd>{placed}</dd>
        <dt>Chi-squared</dt>
        <dd>{agreement({ ...shown, switchedOff: [] })}</dd>
        {shown.switchedOff.length > 0 && (
          <>
            <dt>Not used</dt>
            <dd>
              {shown.switchedOff.map((name) => (
                <div key={name}>{titleOf(live, name)}</div>
              ))}
            </dd>
          </>
        )}
      </dl>
    </section>
  );
}

function Row({ movement: { map, distance, turn } }: { movement: Movement }) {
  const live = useLive();
  const selected = useSelection();
  return (
    <tr aria-selected={map === selected}>
      <td>
        <button className="share-name" onClick={() => select(map)}>
          {titleOf(live, map)}
        </button>
      </td>
      <td className="number">{distance < 1 ? `${(100 * distance).toFixed(1)} cm` : metres(distance)}</td>
      <td className="number">{turned(turn)}</td>
    </tr>
  );
}

function Moved({ moved }: { moved: Movement[] }) {
  return (
    <div className="card table-scroll">
      <table className="table movement">
        <thead>
          <tr>
            <th scope="col">Map</th>
            <th scope="col" className="number">Moved</th>
            <th scope="col" className="number">Turned</th>
          </tr>
        </thead>
        <tbody>
          {moved.map((movement) => (
            <Row key={movement.map} movement={movement} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

// What else there is to say of the maps.
function Others({ difference: { moved, still, appeared, gone } }: { difference: Found }) {
  const live = useLive();
  // Maps that have been merged into others since have no name any more.
  const names = (maps: string[]) => {
    const known = maps.filter((map) => live.maps.has(map));
    const lost = maps.length - known.length;
    return [...known.map((map) => titleOf(live, map)), ...(lost > 0 ? [count(lost, 'map that is gone now', 'maps that are gone now')] : [])].join(', ');
  };
  return (
    <>
      {still > 0 && <p className="sub">{moved.length === 0 ? 'No map has moved.' : `${count(still, 'map has', 'maps have')} not moved.`}</p>}
      {appeared.length > 0 && <p className="sub">Placed only here: {names(appeared)}.</p>}
      {gone.length > 0 && <p className="sub">Placed only before: {names(gone)}.</p>}
    </>
  );
}

export function Difference({ versions, shown, other, difference, count: placed, stretch, setStretch }: Props) {
  const before = versions.filter((version) => version !== shown).reverse();
  return (
    <>
      <Facts shown={shown} count={placed} />
      <section className="inspector-part">
        <h2>How the maps have moved</h2>
        {before.length > 0 && (
          <label className="choice">
            Since version
            <select className="select" value={other ? String(other.graphVersion) : ''} onChange={(event) => setQuery({ from: event.target.value || undefined })}>
              {!other && <option value="">choose a version</option>}
              {before.map(({ graphVersion, createTime }) => (
                <option key={String(graphVersion)} value={String(graphVersion)}>
                  {String(graphVersion)}
                  {createTime && `, ${dateTime(timestampMs(createTime))}`}
                </option>
              ))}
            </select>
          </label>
        )}
        {!other ? (
          <p className="sub">This is the oldest placing that is kept.</p>
        ) : !difference ? (
          <Loading rows={3} />
        ) : (
          <>
            {difference.moved.length > 0 && (
              <>
                <label className="choice">
                  Arrows
                  <select className="select" value={stretch} onChange={(event) => setStretch(Number(event.target.value))}>
                    {stretches.map((factor) => (
                      <option key={factor} value={factor}>
                        {factor === 1 ? 'to scale' : `${factor} times as long`}
                      </option>
                    ))}
                  </select>
                </label>
                <Moved moved={difference.moved} />
              </>
            )}
            <Others difference={difference} />
          </>
        )}
        <p className="sub">Distances are those of a map’s middle; turns are counter-clockwise. {stretch === 1 ? 'Dashed frames show where maps were.' : 'A dashed frame shows where the selected map was.'} Maps look as they do now.</p>
      </section>
    </>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { idOf } from '../../api/names';
import { setQuery } from '../../app/router';
import type { MapRevision } from '../../gen/enfilade/v1/map_pb';
import type { DiffMapRevisionsResponse } from '../../gen/enfilade/v1/map_service_pb';
import type { Compare } from '../../scene/model';
import { count } from '../../ui/format';
import { Icon } from '../../ui/Icon';

const titles: Record<Compare, string> = { difference: 'Difference', swipe: 'Swipe', blink: 'Blink' };

interface Props {
  shown: MapRevision;
  other: MapRevision;
  compare: Compare;
  blinked: boolean;
  swipe: number;
  setSwipe: (place: number) => void;
  // Absent while it is read.
  difference: DiffMapRevisionsResponse | undefined;
}

// How two revisions are compared, over the map.
export function CompareBar({ shown, other, compare, blinked, swipe, setSwipe, difference }: Props) {
  const [a, b] = [idOf(other.name), idOf(shown.name)];
  return (
    <div className="compare">
      {compare === 'swipe' && <div className="swipe-border" style={{ left: `${100 * swipe}%` }} />}
      <div className="compare-kinds" role="group" aria-label="Compare">
        {(Object.keys(titles) as Compare[]).map((kind) => (
          <button key={kind} className="button" aria-pressed={kind === compare} onClick={() => setQuery({ cmp: kind })}>
            {titles[kind]}
          </button>
        ))}
      </div>
      {compare === 'difference' && (
        <span className="compare-legend">
          <i className="swatch before" /> walls only in {a} <i className="swatch after" /> only in {b} <i className="swatch both" /> in both
        </span>
      )}
      {compare === 'swipe' && (
        <label className="compare-legend">
          {a}
          <input type="range" min="0" max="1" step="0.005" value={swipe} aria-label={`Border between ${a} and ${b}`} onChange={(event) => setSwipe(Number(event.target.value))} />
          {b}
        </label>
      )}
      {difference && <span className="compare-legend">{count(Number(difference.regionCount), 'place')} changed</span>}
      {compare === 'blink' && <span className="compare-legend">Revision {blinked ? a : b}</span>}
      <button className="button icon plain" aria-label="End the comparison" title="End the comparison" onClick={() => setQuery({ with: undefined, cmp: undefined })}>
        <Icon name="close" />
      </button>
    </div>
  );
}

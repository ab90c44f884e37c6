// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';
import { problemOf } from '../../../api/errors';
import { spreadOf, spreadText } from '../../../graph/spread';
import type { AlignMapsResponse } from '../../../gen/enfilade/v1/graph_service_pb';
import { wrapped } from '../../../scene/se2';
import { Badge } from '../../../ui/Badge';
import { pose as poseText } from '../../../ui/format';
import { MergeForm } from './MergeForm';
import { NumberField } from './NumberField';
import type { Aligning, Pair } from './useAlign';

const DEG = 180 / Math.PI;

function Answer({ answer }: { answer: AlignMapsResponse }) {
  const { accepted, reason, poseAB, score, overlapM2, rivalRatio } = answer;
  return (
    <div role="status">
      <p className={accepted ? undefined : 'refusal'}>
        <Badge tone={accepted ? 'good' : 'bad'}>{accepted ? 'The maps fit here, and nowhere else' : `Not accepted: ${reason}`}</Badge>
      </p>
      {poseAB?.pose && (
        <dl className="facts">
          <dt>Place</dt>
          <dd>{poseText(poseAB.pose)}</dd>
          <dt>Uncertainty (1 σ)</dt>
          <dd>{spreadText(spreadOf(poseAB.covariance))}</dd>
          <dt>Walls that agree</dt>
          <dd>{Math.round(100 * score)} %</dd>
          <dt>Both have seen</dt>
          <dd>{overlapM2.toFixed(1)} m²</dd>
          <dt>Against the best other place</dt>
          <dd>{rivalRatio > 0 ? `${rivalRatio.toFixed(2)} times as good` : 'there is none'}</dd>
        </dl>
      )}
    </div>
  );
}

interface Props {
  pair: Pair;
  align: Aligning;
  titleOf: (name: string) => string;
  make: (answer: AlignMapsResponse) => void;
  // There are changes of link points that are not saved: those come first.
  isDrafting: boolean;
}

// One map laid over another one: by hand, by numbers, and by what robots have seen of both.
export function AlignPanel({ pair, align: { find, move, end }, titleOf, make, isDrafting }: Props) {
  const { guess } = pair;
  const [radiusM, setRadius] = useState(5);
  const [yawRange, setYawRange] = useState(0.5);
  const [isMerging, setMerging] = useState(false);
  const answer = find.data;
  return (
    <section className="inspector-part" aria-label="Align two maps">
      <h1>Align</h1>
      <p>
        <span className="swatch before" /> {titleOf(pair.a)} stays, <span className="swatch after" /> {titleOf(pair.b)} is laid over it, <span className="swatch both" /> walls of both.
      </p>
      <p className="sub">Drag {titleOf(pair.b)}, turn it by its corner, or enter where its frame is in {titleOf(pair.a)}. The server then looks around that place, and the opposite way round.</p>
      <div className="numbers">
        <NumberField label="x, m" value={guess.x} digits={3} step={0.1} onChange={(x) => move({ ...guess, x })} />
        <NumberField label="y, m" value={guess.y} digits={3} step={0.1} onChange={(y) => move({ ...guess, y })} />
        <NumberField label="Direction, °" value={guess.yaw * DEG} digits={2} step={1} onChange={(yaw) => move({ ...guess, yaw: wrapped(yaw / DEG) })} />
        <NumberField label="Look around, m" value={radiusM} digits={2} step={1} min={0.1} max={20} onChange={setRadius} />
        <NumberField label="and turned by, °" value={yawRange * DEG} digits={1} step={5} min={1} max={180} onChange={(yaw) => setYawRange(Math.min(Math.PI, yaw / DEG))} />
      </div>
      <div className="actions">
        <button className="button primary" disabled={find.isPending} onClick={() => find.mutate({ pair, reach: { radiusM, yawRange } })}>
          Find the place
        </button>
        <button className="button" disabled={!answer?.accepted} onClick={() => answer && make(answer)}>
          Make a link point
        </button>
        <button className="button" disabled={!answer?.accepted || isDrafting} onClick={() => setMerging(true)}>
          Merge …
        </button>
        <button className="button" onClick={end}>
          Close
        </button>
      </div>
      {find.isPending && <p role="status">Comparing the maps …</p>}
      {find.error && (
        <p className="refusal" role="alert">
          {problemOf(find.error).title}: {problemOf(find.error).text}
        </p>
      )}
      {answer && <Answer answer={answer} />}
      {answer?.accepted && isMerging && <MergeForm into={pair.a} merged={pair.b} pose={guess} done={() => setMerging(false)} after={end} />}
      {answer && !answer.accepted && <p className="sub">A link point can still be made by hand: close this, choose a map, and make a new link point that leads to the other one.</p>}
    </section>
  );
}

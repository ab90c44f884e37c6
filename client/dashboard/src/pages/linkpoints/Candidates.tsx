// SPDX-License-Identifier: Apache-2.0
import '../sessions/session.css';
import './candidates.css';
import { useMutation, useQuery } from '@tanstack/react-query';
import { useState } from 'react';
import { collect, graphs, linkPoints } from '../../api/clients';
import { problemOf } from '../../api/errors';
import { idOf, siteName } from '../../api/names';
import { Link } from '../../app/router';
import { inEditor, onCampus } from '../../app/selection';
import { deletionsOf, everything, fits, imagesOf, linedUp, portions, suspensionsOf, type Wanted } from '../../graph/candidates';
import { kindNames } from '../../graph/differences';
import { placeOf } from '../../graph/draft';
import { lengthText } from '../../graph/preview';
import { spreadOf, spreadText } from '../../graph/spread';
import { LinkPoint_Kind as Kind, LinkPoint_Use as Use, type LinkPoint } from '../../gen/enfilade/v1/link_point_pb';
import { LinkPointSubset } from '../../gen/enfilade/v1/link_point_service_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { byName, count, pose, shortened } from '../../ui/format';
import { Empty, Failed, Loading } from '../../ui/States';
import { Confirm } from '../../ui/Confirm';
import { Picture } from '../sessions/DoorImages';

const PAGE = 20;

function Pictures({ point }: { point: LinkPoint }) {
  const images = imagesOf(point);
  if (images.length === 0) return <p className="sub">No pictures are kept of this place.</p>;
  return (
    <div className="series-images">
      {images.map((image, i) => (
        <Picture key={i} image={image} what="Kept of the place" />
      ))}
    </div>
  );
}

function Candidate({ point, isChosen, choose }: { point: LinkPoint; isChosen: boolean; choose: (on: boolean) => void }) {
  const live = useLive();
  const anchor = point.anchors[0];
  const title = `${kindNames[point.kind]} in ${anchor ? titleOf(live, anchor.map) : '–'}`;
  const place = anchor && placeOf(anchor);
  return (
    <li className="candidate">
      <div className="candidate-head">
        <label className="choice">
          <input type="checkbox" checked={isChosen} onChange={(event) => choose(event.target.checked)} aria-label={`Select ${title} ${shortened(idOf(point.name))}`} />
          <strong>{title}</strong>
          {point.use === Use.SUSPENDED && <span className="sub">suspended</span>}
          {point.tag !== '' && <span className="sub">{point.tag}</span>}
        </label>
        <span className="sub mono">{shortened(idOf(point.name))}</span>
        {place && <span className="sub">{`${pose(place.pose)}, σ ${spreadText(spreadOf(place.covariance))}`}</span>}
        <span className="candidate-actions">
          <Link className="button" href={onCampus(live.id, point.name)}>
            Show on the campus
          </Link>
          <Link className="button" href={inEditor(live.id, point.name)}>
            Promote …
          </Link>
        </span>
      </div>
      <Pictures point={point} />
    </li>
  );
}

function Filters({ wanted, set }: { wanted: Wanted; set: (wanted: Wanted) => void }) {
  const live = useLive();
  const maps = [...live.maps.values()].sort((a, b) => byName(a.displayName, b.displayName));
  return (
    <div className="table-tools">
      <input className="field" type="search" placeholder="Search candidates" aria-label="Search candidates" value={wanted.text} onChange={(event) => set({ ...wanted, text: event.target.value })} />
      <select className="select" aria-label="Map" value={wanted.map} onChange={(event) => set({ ...wanted, map: event.target.value })}>
        <option value="">all maps</option>
        {maps.map(({ map, displayName }) => (
          <option key={map} value={map}>
            {displayName}
          </option>
        ))}
      </select>
      <select className="select" aria-label="Kind" value={wanted.kind} onChange={(event) => set({ ...wanted, kind: Number(event.target.value) })}>
        <option value={Kind.UNSPECIFIED}>all kinds</option>
        {[Kind.DOOR, Kind.LIFT, Kind.STAIRS, Kind.RAMP, Kind.OPENING].map((kind) => (
          <option key={kind} value={kind}>
            {kindNames[kind]}
          </option>
        ))}
      </select>
      <select className="select" aria-label="Pictures" value={wanted.pictures} onChange={(event) => set({ ...wanted, pictures: event.target.value as Wanted['pictures'] })}>
        <option value="all">with or without pictures</option>
        <option value="with">with pictures</option>
        <option value="without">without pictures</option>
      </select>
    </div>
  );
}

type Act = 'delete' | 'suspend' | 'line';

function changesBy(act: Act, points: LinkPoint[]) {
  if (act === 'line') return linedUp(points)?.changes ?? [];
  return act === 'delete' ? deletionsOf(points) : suspensionsOf(points);
}

// What is asked before it is done.
function questionOf(act: Act, points: LinkPoint[]) {
  const many = count(points.length, 'candidate');
  if (act === 'delete') {
    return { title: `Delete ${many}?`, act: 'Delete them', lines: ['They go with their pictures. Taking that back (History, audit trail) brings back the places, but not the pictures.'], refusal: undefined };
  }
  if (act === 'suspend') return { title: `Suspend ${many}?`, act: 'Suspend them', lines: ['Robots’ reports no longer meet them until they are resumed.'], refusal: undefined };
  const line = linedUp(points);
  return {
    title: `Put ${many} on a line?`, act: 'Put them on it', lines: line ? [`They move onto the line that fits them best, by at most ${lengthText(line.farthest)}, and count as placed by hand.`] : [],
    refusal: line ? undefined : 'A line needs at least three candidates, all of one map.',
  };
}

// The doors that were seen and not yet passed, with what was seen of them.
export function Candidates() {
  const live = useLive();
  const [wanted, setWanted] = useState(everything);
  const [chosen, setChosen] = useState<ReadonlySet<string>>(new Set());
  const [asking, setAsking] = useState<Act>();
  const [most, setMost] = useState(PAGE);
  const { data, error, refetch } = useQuery({
    queryKey: ['candidates', live.id, String(live.graphVersion)],
    placeholderData: (earlier: LinkPoint[] | undefined) => earlier,
    queryFn: () => collect(async (pageToken) => {
      const answer = await linkPoints.listLinkPoints({ parent: siteName(live.id), subset: LinkPointSubset.CANDIDATES, pageSize: 1000, pageToken });
      return [answer.linkPoints, answer.nextPageToken];
    }),
  });
  const title = (name: string) => titleOf(live, name);
  const found = (data ?? []).filter((point) => fits(point, wanted, title));
  const picked = found.filter(({ name }) => chosen.has(name));
  const change = useMutation({
    mutationFn: async (act: Act) => {
      for (const changes of portions(changesBy(act, picked))) await graphs.changeGraph({ site: siteName(live.id), changes });
    },
    onSuccess: () => {
      setChosen(new Set());
      setAsking(undefined);
    },
    onSettled: () => refetch(),
  });
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (data.length === 0) return <Empty title="No candidates">Doors that a robot has seen and nobody has passed are listed here. There are none now.</Empty>;
  const toggle = (name: string, on: boolean) => setChosen((before) => new Set(on ? [...before, name] : [...before].filter((one) => one !== name)));
  return (
    <>
      <Filters wanted={wanted} set={setWanted} />
      <div className="table-tools" role="group" aria-label="With the selected candidates">
        <label className="choice">
          <input type="checkbox" checked={picked.length > 0 && picked.length === found.length} onChange={(event) => setChosen(new Set(event.target.checked ? found.map(({ name }) => name) : []))} /> All that are listed
        </label>
        <span className="sub" role="status">
          {`${found.length} of ${count(data.length, 'candidate')}, ${picked.length} selected`}
        </span>
        <button className="button" disabled={picked.length === 0} onClick={() => setAsking('line')}>
          Put on a line …
        </button>
        <button className="button" disabled={picked.length === 0} onClick={() => setAsking('suspend')}>
          Suspend …
        </button>
        <button className="button" disabled={picked.length === 0} onClick={() => setAsking('delete')}>
          Delete …
        </button>
      </div>
      {asking && picked.length > 0 && (
        <Confirm {...questionOf(asking, picked)} keep="Leave them" busy={change.isPending} onAct={() => change.mutate(asking)} onKeep={() => setAsking(undefined)} />
      )}
      {change.error && (
        <p className="refusal" role="alert">
          {problemOf(change.error).title}: {problemOf(change.error).text}
        </p>
      )}
      <ul className="card candidates" aria-label="Candidates">
        {found.slice(0, most).map((point) => (
          <Candidate key={point.name} point={point} isChosen={chosen.has(point.name)} choose={(on) => toggle(point.name, on)} />
        ))}
        {found.length === 0 && <li className="candidate sub">Nothing fits. Choose all maps and kinds, and clear the search.</li>}
      </ul>
      {found.length > most && (
        <button className="button" onClick={() => setMost(most + PAGE)}>
          Show {Math.min(PAGE, found.length - most)} more
        </button>
      )}
    </>
  );
}

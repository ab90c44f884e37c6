// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { useState } from 'react';
import { collect, sessions } from '../../api/clients';
import { problemOf } from '../../api/errors';
import { onCampus } from '../../app/selection';
import { Link } from '../../app/router';
import { DoorVerdict_Decision, type DoorComparison, type DoorVerdict } from '../../gen/enfilade/v1/door_pb';
import type { GetDoorImagesResponse } from '../../gen/enfilade/v1/session_service_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { Badge } from '../../ui/Badge';
import { count, metres } from '../../ui/format';
import { Failed, Loading } from '../../ui/States';
import { Series, useDoorImages } from './DoorImages';
import { decisions } from './states';

// Sites with many doors compare one passage with many link points: the rest is counted.
const SHOWN = 5;

const GONE = 'a link point that is gone';

// Candidates that became one link point are gone.
function Place({ linkPoint }: { linkPoint: string }) {
  const live = useLive();
  if (!live.linkPoints.has(linkPoint)) return <span>{GONE}</span>;
  return <Link href={onCampus(live.id, linkPoint)}>{titleOf(live, linkPoint)}</Link>;
}

const agreement = (agree: boolean) => (agree ? 'agree' : 'do not agree');

// What each of the senses says of two places.
function Measures({ comparison: { imageMatches, imagesAgree, registrationRmseM, registrationInlierShare, cloudsAgree, chi2, distanceM } }: { comparison: DoorComparison }) {
  return (
    <dl className="facts measures">
      <dt>Images</dt>
      <dd>{imageMatches < 0 ? 'none to compare' : `${count(imageMatches, 'match', 'matches')}, ${agreement(imagesAgree)}`}</dd>
      <dt>Clouds</dt>
      <dd>
        {registrationRmseM < 0
          ? 'none to compare'
          : `${Math.round(100 * registrationInlierShare)} % of the points have a partner, ${metres(registrationRmseM)} apart (RMS), ${agreement(cloudsAgree)}`}
      </dd>
      <dt>Graph</dt>
      <dd>
        {distanceM < 0 ? 'no link points lead there' : `${metres(distanceM)} away`}
        {chi2 >= 0 && `, chi-squared ${chi2.toFixed(1)}`}
      </dd>
    </dl>
  );
}

function Comparison({ comparison, images, index }: { comparison: DoorComparison; images: GetDoorImagesResponse | undefined; index: number }) {
  const live = useLive();
  const known = live.linkPoints.has(comparison.linkPoint);
  // The best one is what the verdict is about.
  const [open, setOpen] = useState(index === 0);
  return (
    <li>
      <details open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>
          <Badge tone={comparison.accepted ? 'good' : 'quiet'}>{comparison.accepted ? 'Same place' : 'Another place'}</Badge>{' '}
          {known ? titleOf(live, comparison.linkPoint) : GONE}
          {comparison.distanceM >= 0 && <span className="sub">, {metres(comparison.distanceM)} away</span>}
        </summary>
        {open && (
          <div className="compared">
            <Measures comparison={comparison} />
            <p className="sub">
              {comparison.reason}. {known && <Link href={onCampus(live.id, comparison.linkPoint)}>Show the place on the campus</Link>}
            </p>
            {images && (
              <div className="side-by-side">
                <Series title="What the robot saw" images={images.seen} what="Seen by the robot" none="No images of this door are stored." />
                <Series title={`What is kept of this place in ${titleOf(live, comparison.map)}`} images={images.kept[index]?.images ?? []} what="Kept of the place" none="No images are kept of this place." />
              </div>
            )}
          </div>
        )}
      </details>
    </li>
  );
}

// Of a report that was compared with nothing.
function Seen({ verdict, images, show }: { verdict: DoorVerdict; images: GetDoorImagesResponse | undefined; show: () => void }) {
  return (
    <details onToggle={show}>
      <summary>What the robot saw</summary>
      {images && <Series title={`At the door of record ${verdict.name.split('/').pop()}`} images={images.seen} what="Seen by the robot" none="No images of this door are stored." />}
    </details>
  );
}

function Verdict({ verdict }: { verdict: DoorVerdict }) {
  const [wanted, setWanted] = useState(verdict.comparisons.length > 0);
  const { data: images, error } = useDoorImages(verdict.name, wanted);
  const judged = verdict.decision !== DoorVerdict_Decision.NOT_JUDGED;
  const rest = verdict.comparisons.length - SHOWN;
  return (
    <li className="verdict">
      <Badge tone={judged ? 'good' : 'warn'}>{decisions[verdict.decision]}</Badge>
      <p>
        {verdict.linkPoint !== '' && <Place linkPoint={verdict.linkPoint} />} <span className="sub">{verdict.reason}</span>
      </p>
      {error && <p role="alert">The images cannot be read: {problemOf(error).text}</p>}
      {verdict.comparisons.length === 0 ? (
        <Seen verdict={verdict} images={images} show={() => setWanted(true)} />
      ) : (
        <ul className="comparisons" aria-label="Compared with">
          {verdict.comparisons.slice(0, SHOWN).map((comparison, i) => (
            <Comparison key={i} comparison={comparison} images={images} index={i} />
          ))}
          {rest > 0 && <li className="sub">and {rest} more</li>}
        </ul>
      )}
    </li>
  );
}

export function Verdicts({ session }: { session: string }) {
  const { data, error, refetch } = useQuery({
    queryKey: ['verdicts', session],
    queryFn: () => collect(async (pageToken) => {
      const answer = await sessions.listDoorVerdicts({ parent: session, pageSize: 1000, pageToken });
      return [answer.verdicts, answer.nextPageToken];
    }),
  });
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading rows={2} />;
  if (data.length === 0) return <p className="sub">None: the robot reported no door in this session.</p>;
  return (
    <ul className="card verdicts">
      {data.map((verdict) => (
        <Verdict key={verdict.name} verdict={verdict} />
      ))}
    </ul>
  );
}

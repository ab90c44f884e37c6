// SPDX-License-Identifier: Apache-2.0
import { useQuery } from '@tanstack/react-query';
import { collect, sessions } from '../../api/clients';
import { onCampus } from '../../app/selection';
import { Link } from '../../app/router';
import { DoorVerdict_Decision, type DoorComparison, type DoorVerdict } from '../../gen/enfilade/v1/door_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { Badge } from '../../ui/Badge';
import { metres } from '../../ui/format';
import { Failed, Loading } from '../../ui/States';
import { decisions } from './states';

// Sites with many doors compare one passage with many link points: the rest is counted.
const SHOWN = 5;

// Candidates that became one link point are gone.
function Place({ linkPoint }: { linkPoint: string }) {
  const live = useLive();
  if (!live.linkPoints.has(linkPoint)) return <span>a link point that is gone</span>;
  return <Link href={onCampus(live.id, linkPoint)}>{titleOf(live, linkPoint)}</Link>;
}

function Comparison({ comparison }: { comparison: DoorComparison }) {
  return (
    <li>
      <Badge tone={comparison.accepted ? 'good' : 'quiet'}>{comparison.accepted ? 'Same place' : 'Another place'}</Badge>{' '}
      <Place linkPoint={comparison.linkPoint} />
      <span className="sub">
        , {metres(comparison.distanceM)} away: {comparison.reason}
      </span>
    </li>
  );
}

function Verdict({ verdict }: { verdict: DoorVerdict }) {
  const judged = verdict.decision !== DoorVerdict_Decision.NOT_JUDGED;
  const rest = verdict.comparisons.length - SHOWN;
  return (
    <li className="verdict">
      <Badge tone={judged ? 'good' : 'warn'}>{decisions[verdict.decision]}</Badge>
      <p>
        {verdict.linkPoint !== '' && <Place linkPoint={verdict.linkPoint} />} <span className="sub">{verdict.reason}</span>
      </p>
      {verdict.comparisons.length > 0 && (
        <ul className="comparisons" aria-label="Compared with">
          {verdict.comparisons.slice(0, SHOWN).map((comparison, i) => (
            <Comparison key={i} comparison={comparison} />
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

// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { graphs, linkPoints } from '../../api/clients';
import { problemOf } from '../../api/errors';
import { siteName } from '../../api/names';
import { changesIn, sameTime, transactionOf } from '../../graph/audited';
import { inverseOf } from '../../graph/inverse';
import { effectsOf, sentencesOf } from '../../graph/preview';
import type { LinkPoint } from '../../gen/enfilade/v1/link_point_pb';
import type { AuditEntry } from '../../gen/enfilade/v1/site_service_pb';
import { useLive } from '../../live/context';
import { distinctTitleOf } from '../../live/objects';
import { Badge } from '../../ui/Badge';
import { Failed, Loading } from '../../ui/States';
import { Confirm } from '../../ui/Confirm';
import { useRearrangements } from './rearrangements';

// A request takes so many.
const MOST_CHANGES = 100;

interface Props {
  // Of the whole list, the newest first.
  entries: readonly AuditEntry[];
  entry: AuditEntry;
  // The list ends here, and the transaction may go on.
  isCut: boolean;
  done: () => void;
}

// Takes back what one transaction has done with link points, by the opposite changes: they are in the audit trail, too.
export function TakeBack({ entries, entry, isCut, done }: Props) {
  const live = useLive();
  const queries = useQueryClient();
  const title = (name: string) => distinctTitleOf(live, name);
  const own = transactionOf(entries, entry);
  const changes = changesIn(own);
  const { data: rearrangements } = useRearrangements(live.id);
  const rearranged = rearrangements?.find(({ createTime, undoTime }) => sameTime(createTime, entry.time) || sameTime(undoTime, entry.time));
  const plan = useQuery({
    queryKey: ['takeBack', live.id, String(entry.time?.seconds), entry.time?.nanos, String(live.graphVersion)],
    queryFn: async () => {
      const present = new Map<string, LinkPoint | undefined>();
      for (const { linkPoint } of changes) present.set(linkPoint, live.linkPoints.has(linkPoint) ? (await linkPoints.getLinkPoint({ name: linkPoint })).linkPoint : undefined);
      const inverse = inverseOf(changes, present, title);
      const isSendable = inverse.refusals.length === 0 && inverse.changes.length > 0 && inverse.changes.length <= MOST_CHANGES;
      const effects = isSendable ? effectsOf(await graphs.previewGraph({ site: siteName(live.id), changes: inverse.changes }), (map) => live.maps.get(map)?.poseWorldMap !== undefined) : undefined;
      return { inverse, effects };
    },
  });
  const act = useMutation({
    mutationFn: async () => graphs.changeGraph({ site: siteName(live.id), changes: plan.data!.inverse.changes }),
    onSuccess: async () => {
      await queries.invalidateQueries({ queryKey: ['audit', live.id] });
      done();
    },
    onError: () => plan.refetch(),
  });
  if (plan.error) return <Failed error={plan.error} retry={() => void plan.refetch()} />;
  if (!plan.data || !rearrangements) return <Loading rows={3} />;
  const { inverse, effects } = plan.data;
  const refusal =
    rearranged ? 'Maps were merged or split then: undo that under “Merges and splits”, which restores all of it.'
    : isCut && own.at(-1) === entries.at(-1) ? 'The list ends within this change: it is too old to be taken back here.'
    : inverse.refusals.length > 0 ? inverse.refusals.join(' ')
    : inverse.changes.length === 0 ? 'There is nothing left to take back.'
    : inverse.changes.length > MOST_CHANGES ? `This needs ${inverse.changes.length} changes at once; at most ${MOST_CHANGES} are possible. Change the link points on the campus instead.`
    : undefined;
  return (
    <Confirm title="Take this change back?" lines={inverse.lines} refusal={refusal} act="Take it back" keep="Leave it" busy={act.isPending} onAct={() => act.mutate()} onKeep={done}>
      {inverse.warnings.map((line) => (
        <Badge key={line} tone="warn">
          {line}
        </Badge>
      ))}
      {effects && sentencesOf(effects, title).map(({ tone, text }) => (
        <Badge key={text} tone={tone}>
          {text}
        </Badge>
      ))}
      {act.error && (
        <p className="refusal" role="alert">
          {problemOf(act.error).title}: {problemOf(act.error).text}
        </p>
      )}
    </Confirm>
  );
}

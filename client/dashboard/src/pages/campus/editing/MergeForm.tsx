// SPDX-License-Identifier: Apache-2.0
import { useMutation } from '@tanstack/react-query';
import { maps } from '../../../api/clients';
import { problemOf } from '../../../api/errors';
import { select } from '../../../app/selection';
import { planMerge } from '../../../graph/rearranging';
import { useLive } from '../../../live/context';
import { titleOf } from '../../../live/objects';
import type { Pose } from '../../../scene/camera';
import { pose as poseText } from '../../../ui/format';
import { Failed, Loading } from '../../../ui/States';
import { Confirm } from '../../../ui/Confirm';
import { useSessionsOfSite } from './useSessions';

interface Props {
  into: string;
  merged: string;
  // T_into_merged as two maps were aligned; undefined: by the graph.
  pose: Pose | undefined;
  done: () => void;
  // They are one map now; without it `done` is called.
  after?: () => void;
}

// Two maps that are one room.
export function MergeForm({ into, merged, pose, done, after = done }: Props) {
  const live = useLive();
  const { data: sessions, error, refetch } = useSessionsOfSite(live.id);
  const merge = useMutation({
    mutationFn: () => maps.mergeMaps({ name: into, mergedMap: merged, ...(pose && { poseNameMerged: pose }) }),
    onSuccess: ({ map }) => {
      if (map) select(map.name);
      after();
    },
  });
  if (error) return <Failed error={error} retry={() => void refetch()} />;
  if (!sessions) return <Loading rows={3} />;
  const plan = planMerge(into, merged, live.rootMap, [...live.linkPoints.values()], sessions, (name) => titleOf(live, name));
  return (
    <Confirm title={`Merge “${titleOf(live, plan.goes)}” into “${titleOf(live, plan.stays)}”?`} lines={plan.lines} refusal={plan.refusal} act="Merge them" keep="Keep both"
      busy={merge.isPending} onAct={() => merge.mutate()} onKeep={done}>
      <p className="sub">{pose ? `By the place that they were aligned at: ${poseText(pose)}.` : 'By the link points between them, if these are sure of it. Else align them first.'}</p>
      {merge.isPending && <p role="status">Drawing the map anew …</p>}
      {merge.error && (
        <p className="refusal" role="alert">
          {problemOf(merge.error).title}: {problemOf(merge.error).text}
        </p>
      )}
    </Confirm>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { lastChangeOf } from '../../../api/audit';
import { differencesOf } from '../../../graph/differences';
import type { Draft, Edit } from '../../../graph/draft';
import type { LinkPoint } from '../../../gen/enfilade/v1/link_point_pb';
import { useLive } from '../../../live/context';
import { dateTime } from '../../../ui/format';

export interface Conflict {
  edit: Edit;
  // Undefined: it was deleted.
  theirs: LinkPoint | undefined;
}

// Edits of link points that are not what they were when the edit began. `present`: as they are now, null: gone.
export function conflictsOf(draft: Draft, present: ReadonlyMap<string, LinkPoint | null>): Conflict[] {
  return [...draft].flatMap(([name, edit]) => {
    const now = present.get(name);
    if (edit.isNew || now === undefined || now?.etag === edit.base.etag) return [];
    return [{ edit, theirs: now ?? undefined }];
  });
}

interface Props {
  conflict: Conflict;
  titleOf: (name: string) => string;
  takeTheirs: () => void;
  layMine: (theirs: LinkPoint) => void;
}

// What somebody else has made of a link point that is being edited here.
export function ConflictNotice({ conflict: { edit, theirs }, titleOf, takeTheirs, layMine }: Props) {
  const live = useLive();
  const { name } = edit.base;
  const { data: last } = useQuery({ queryKey: ['lastChange', name, theirs?.etag ?? ''], queryFn: async () => (await lastChangeOf(live.id, name)) ?? null });
  const who = last?.actor === '' || !last ? 'Somebody' : last.actor;
  return (
    <section className="conflict" role="alert" aria-label={`Changed by somebody else: ${titleOf(name)}`}>
      <h2>{titleOf(name)} has been changed meanwhile</h2>
      <p>
        {who} has changed it{last?.time && ` at ${dateTime(timestampMs(last.time))}`}:
      </p>
      <ul>
        {differencesOf(edit.base, theirs, titleOf).map((line) => (
          <li key={line}>{line}</li>
        ))}
      </ul>
      <div className="actions">
        <button className="button" onClick={takeTheirs}>
          {theirs ? 'Load theirs, drop mine' : 'Drop mine'}
        </button>
        {theirs && (
          <button className="button" onClick={() => layMine(theirs)}>
            Keep mine on top
          </button>
        )}
      </div>
    </section>
  );
}

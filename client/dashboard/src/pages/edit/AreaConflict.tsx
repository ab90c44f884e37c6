// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { lastChangeOf } from '../../api/audit';
import { differencesOf, fieldsOf } from '../../edit/areas';
import type { MapArea } from '../../gen/enfilade/v1/map_area_pb';
import { useLive } from '../../live/context';
import { dateTime } from '../../ui/format';

interface Props {
  before: MapArea;
  // Undefined: it was deleted.
  theirs: MapArea | undefined;
  takeTheirs: () => void;
  layMine: (theirs: MapArea) => void;
}

// What somebody else has made of an area that is being edited here.
export function AreaConflict({ before, theirs, takeTheirs, layMine }: Props) {
  const live = useLive();
  const { name, displayName } = before;
  const { data: last } = useQuery({ queryKey: ['lastChange', name, theirs?.etag ?? ''], queryFn: async () => (await lastChangeOf(live.id, name)) ?? null });
  const who = last?.actor === '' || !last ? 'Somebody' : last.actor;
  return (
    <section className="edit-warning" role="alert" aria-label={`Changed by somebody else: ${displayName}`}>
      <p>
        {who} has {theirs ? 'changed' : 'deleted'} “{displayName}” meanwhile{last?.time && `, at ${dateTime(timestampMs(last.time))}`}
        {theirs ? ':' : '.'}
      </p>
      {theirs && (
        <ul>
          {differencesOf(fieldsOf(before), fieldsOf(theirs)).map((line) => (
            <li key={line}>{line}</li>
          ))}
        </ul>
      )}
      <div className="actions">
        <button className="button" type="button" onClick={takeTheirs}>
          {theirs ? 'Load theirs, drop mine' : 'Drop mine'}
        </button>
        {theirs && (
          <button className="button" type="button" onClick={() => layMine(theirs)}>
            Keep mine on top
          </button>
        )}
      </div>
    </section>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { idOf } from '../../api/names';
import { MapRevision_Source, type MapRevision } from '../../gen/enfilade/v1/map_pb';
import { dateTime } from '../../ui/format';

function originOf({ source, session }: MapRevision): string {
  if (source === MapRevision_Source.IMPORT) return 'Imported';
  if (source === MapRevision_Source.EDIT) return 'Edited';
  if (source === MapRevision_Source.RESTORED) return 'Restored';
  return session === '' ? 'Mapped' : `Mapped in session ${idOf(session).slice(0, 8)}`;
}

interface Props {
  revisions: MapRevision[];
  shown: MapRevision;
  other: MapRevision | undefined;
  show: (id: string) => void;
  compareWith: (id: string | undefined) => void;
}

export function RevisionList({ revisions, shown, other, show, compareWith }: Props) {
  return (
    <section className="revisions">
      <h2>
        Revisions <span className="sub">{revisions.length}</span>
      </h2>
      <ul>
        {revisions.map((revision) => {
          const id = idOf(revision.name);
          const isOther = revision === other;
          return (
            <li key={id} className="revision" aria-current={revision === shown}>
              <button className="revision-show" onClick={() => show(id)} title={originOf(revision)}>
                <span className="revision-title">
                  <strong>{id}</strong> {revision === revisions[0] && <span className="sub">newest</span>} {revision.tag !== '' && <span className="sub">{revision.tag}</span>}{' '}
                  {revision.aliases.map((alias) => <span key={alias} className="chip">{alias}</span>)}
                </span>
                <span className="sub">
                  {revision.createTime && dateTime(timestampMs(revision.createTime))} · {revision.session === '' ? originOf(revision) : 'Mapped'}
                </span>
              </button>
              <button className="button small-text" aria-pressed={isOther} disabled={revision === shown} onClick={() => compareWith(isOther ? undefined : id)}>
                Compare
              </button>
            </li>
          );
        })}
      </ul>
      <dl className="facts">
        <dt>Shown</dt>
        <dd>
          {shown.width} × {shown.height} cells of {Math.round(shown.resolutionM * 1000)} mm
        </dd>
        <dt>Source</dt>
        <dd>{originOf(shown)}</dd>
      </dl>
    </section>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { useState, type FormEvent } from 'react';
import { collect, mapEdits } from '../../api/clients';
import { idOf } from '../../api/names';
import { addressOf, Link, navigate } from '../../app/router';
import { uuid } from '../../edit/ids';
import { MapDraft_State, type MapDraft } from '../../gen/enfilade/v1/map_edit_pb';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import { Badge } from '../../ui/Badge';
import { dateTime } from '../../ui/format';
import { refusalOf } from '../../ui/Sending';
import { Failed, Loading } from '../../ui/States';
import { author } from './author';
import { AuthorForm, AuthorLine } from './AuthorForm';
import { Contested } from './Contested';
import { Sure } from './Sure';

const POLL_MS = 10_000;

const draftsKey = (map: string) => ['drafts', map];

export const editAddress = (site: string, map: string, draft?: string) => addressOf(site, 'maps', [idOf(map), 'edit', ...(draft === undefined ? [] : [idOf(draft)])]);

function NewDraft({ map }: { map: string }) {
  const live = useLive();
  const who = author.use();
  const [title, setTitle] = useState('');
  const { mutate, error, isPending } = useMutation({
    mutationFn: async () => (await mapEdits.createMapDraft({ parent: map, requestId: uuid(), draft: { displayName: title.trim(), author: who } })).draft!,
    onSuccess: ({ name }) => navigate(editAddress(live.id, map, name)),
  });
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    mutate();
  };
  if (who === '') return <AuthorForm />;
  return (
    <>
      <form className="edit-new" aria-label="New draft" onSubmit={onSubmit} noValidate>
        <label>
          Name
          <input className="field" maxLength={200} placeholder="what is edited, for example: glass walls" value={title} onChange={(event) => setTitle(event.target.value)} />
        </label>
        <button className="button primary" disabled={isPending}>
          New draft
        </button>
      </form>
      <AuthorLine />
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
    </>
  );
}

function Row({ draft }: { draft: MapDraft }) {
  const live = useLive();
  const queries = useQueryClient();
  const map = draft.name.replace(/\/drafts\/[^/]*$/, '');
  const { mutate, error, isPending } = useMutation({
    mutationFn: () => mapEdits.deleteMapDraft({ name: draft.name, etag: draft.etag }),
    onSettled: () => queries.invalidateQueries({ queryKey: draftsKey(map) }),
  });
  const isOpen = draft.state === MapDraft_State.OPEN;
  const title = draft.displayName || idOf(draft.name).slice(0, 8);
  return (
    <tr>
      <td>{isOpen ? <Link href={editAddress(live.id, map, draft.name)}>{title}</Link> : title}</td>
      <td>{draft.author}</td>
      <td>
        {isOpen ? <Badge tone="warn">Open</Badge> : <Badge tone="good">Published</Badge>}{' '}
        {!isOpen && draft.revision !== '' && <Link href={addressOf(live.id, 'maps', [idOf(map)], { rev: idOf(draft.revision) })}>revision {idOf(draft.revision)}</Link>}
      </td>
      <td className="number">{draft.activeEdits.toString()}</td>
      <td>{draft.createTime ? dateTime(timestampMs(draft.createTime)) : ''}</td>
      <td className="wrap">{draft.message}</td>
      <td>
        {isOpen && <Sure title="Delete" question={`Delete “${title}” and its ${draft.activeEdits} edits?`} keep="Keep it" act="Delete it" busy={isPending} onAct={() => mutate()} />}
        {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
      </td>
    </tr>
  );
}

export function DraftList({ map }: { map: string }) {
  const live = useLive();
  const who = author.use();
  const { data, error, refetch } = useQuery({
    queryKey: draftsKey(map),
    refetchInterval: POLL_MS,
    queryFn: () => collect(async (pageToken) => {
      const { drafts, nextPageToken } = await mapEdits.listMapDrafts({ parent: map, pageSize: 1000, pageToken });
      return [drafts, nextPageToken];
    }),
  });
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  return (
    <div className="page">
      <div className="page-head">
        <h1>
          Edit <Link href={addressOf(live.id, 'maps', [idOf(map)])}>{titleOf(live, map)}</Link>
        </h1>
      </div>
      <p className="sub">Edits are collected in a draft. When it is published they lie over what robots have seen, in this and every later revision.</p>
      <NewDraft map={map} />
      {data.length > 0 && (
        <div className="card table-scroll edit-drafts">
          <table className="table" aria-label="Drafts">
            <thead>
              <tr>
                <th>Draft</th>
                <th>Author</th>
                <th>State</th>
                <th>Edits</th>
                <th>Made</th>
                <th>Message</th>
                <th>
                  <span className="hidden-text">Actions</span>
                </th>
              </tr>
            </thead>
            <tbody>
              {data.map((draft) => (
                <Row key={draft.name} draft={draft} />
              ))}
            </tbody>
          </table>
        </div>
      )}
      {who !== '' && <Contested map={map} />}
    </div>
  );
}

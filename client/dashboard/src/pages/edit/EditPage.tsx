// SPDX-License-Identifier: Apache-2.0
import './edit.css';
import { useQuery } from '@tanstack/react-query';
import { mapEdits } from '../../api/clients';
import { withSite } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { useLive } from '../../live/context';
import { Empty, Failed, Loading } from '../../ui/States';
import { author } from './author';
import { AuthorForm } from './AuthorForm';
import { DraftList } from './DraftList';
import { Editor } from './Editor';

function DraftPage({ name }: { name: string }) {
  const { data, error, refetch } = useQuery({ queryKey: ['draft', name], staleTime: Infinity, queryFn: async () => (await mapEdits.getMapDraft({ name })).draft! });
  const who = author.use();
  if (error && !data) return <Failed error={error} retry={() => void refetch()} />;
  if (!data) return <Loading />;
  if (who === '') {
    return (
      <div className="page">
        <AuthorForm />
      </div>
    );
  }
  return <Editor key={name} draft={data} />;
}

// The drafts of a map, or the editor of one of them: /s/SITE/maps/MAP/edit/DRAFT.
export default function EditPage({ map: id, draft }: { map: string; draft: string | undefined }) {
  const live = useLive();
  const map = withSite(live.id, `maps/${id}`);
  if (!live.complete) return <Loading />;
  // A draft that is open outlives its map, and says where it is.
  if (!live.maps.has(map) && draft === undefined) {
    return (
      <Empty title="This map does not exist">
        It may have been deleted, or merged into another one. <Link href={addressOf(live.id, 'maps')}>All maps of this site</Link>
      </Empty>
    );
  }
  return draft === undefined ? <DraftList map={map} /> : <DraftPage name={`${map}/drafts/${draft}`} />;
}

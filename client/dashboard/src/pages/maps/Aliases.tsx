// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { useState, type FormEvent } from 'react';
import { maps } from '../../api/clients';
import { idOf } from '../../api/names';
import { setQuery } from '../../app/router';
import type { MapAlias, MapRevision } from '../../gen/enfilade/v1/map_pb';
import { Question } from '../../ui/Question';
import { refusalOf } from '../../ui/Sending';
import { aliasesKey, aliasName, beforeOf, isAliasName, offeredAliases } from './versions';

type Act = { set: string; etag: string } | { rollBack: MapAlias } | { remove: MapAlias } | 'restore';

// The etags are those of what the person sees: an alias that somebody else has moved meanwhile stays where it is.
async function act(what: Act, revision: string, map: string): Promise<string | undefined> {
  if (what === 'restore') return (await maps.restoreMapRevision({ name: revision })).revision?.name;
  if ('set' in what) await maps.setMapAlias({ alias: { name: aliasName(map, what.set), revision, etag: what.etag } });
  else if ('rollBack' in what) await maps.rollBackMapAlias({ name: what.rollBack.name, etag: what.rollBack.etag });
  else await maps.deleteMapAlias({ name: what.remove.name, etag: what.remove.etag });
  return undefined;
}

function Alias({ alias, busy, run }: { alias: MapAlias; busy: boolean; run: (what: Act) => void }) {
  const id = idOf(alias.name);
  const before = beforeOf(alias);
  return (
    <li className="alias">
      <button className="alias-show" title={alias.actor === '' ? undefined : `Moved by ${alias.actor}`} onClick={() => setQuery({ rev: idOf(alias.revision) })}>
        <span className="chip">{id}</span> revision {idOf(alias.revision)}
      </button>
      {before !== undefined && (
        <Question title={`Back to ${before}`} question={`Lead ${id} back to revision ${before}?`} yes="Lead it back" no="Keep it" busy={busy} act={() => run({ rollBack: alias })} />
      )}
      <Question title="Delete" question={`Delete ${id}?`} yes="Delete it" no="Keep it" busy={busy} act={() => run({ remove: alias })} />
    </li>
  );
}

// Names that lead to revisions, and what can be done with the revision that is shown.
export function Aliases({ map, shown, isNewest }: { map: string; shown: MapRevision; isNewest: boolean }) {
  const queries = useQueryClient();
  const [typed, setTyped] = useState('');
  const [missing, setMissing] = useState(false);
  const { data: aliases = [] } = useQuery({ queryKey: aliasesKey(map), queryFn: async () => (await maps.listMapAliases({ parent: map })).aliases });
  const { mutate, error, isPending } = useMutation({
    mutationFn: (what: Act) => act(what, shown.name, map),
    onSettled: async (restored) => {
      if (restored !== undefined) setQuery({ rev: undefined, with: undefined });
      await queries.invalidateQueries({ queryKey: aliasesKey(map) });
      await queries.invalidateQueries({ queryKey: ['revisions', map] });
    },
  });
  const set = (id: string) => mutate({ set: id, etag: aliases.find(({ name }) => idOf(name) === id)?.etag ?? '' });
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setMissing(!isAliasName(typed));
    if (isAliasName(typed)) set(typed);
  };
  const id = idOf(shown.name);
  return (
    <section className="aliases" aria-label="Aliases">
      <h2>
        Aliases <span className="sub">{aliases.length}</span>
      </h2>
      <ul>
        {aliases.map((alias) => (
          <Alias key={alias.name} alias={alias} busy={isPending} run={mutate} />
        ))}
      </ul>
      <div className="alias-offers" role="group" aria-label={`Lead to revision ${id}`}>
        <span className="sub">Lead to revision {id}:</span>
        {offeredAliases(aliases, shown.name).map((offered) => (
          <button key={offered} className="button small-text" disabled={isPending} onClick={() => set(offered)}>
            {offered}
          </button>
        ))}
      </div>
      <form className="alias-form" onSubmit={submit}>
        <input className="field" value={typed} aria-label="Another alias" placeholder="another one" onChange={(event) => setTyped(event.target.value)} />
        <button className="button small-text" disabled={isPending}>
          Set
        </button>
      </form>
      {missing && <p className="refusal" role="alert">An alias has 1 to 63 of a-z, 0-9 and “-”.</p>}
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
      {!isNewest && (
        <Question title={`Restore revision ${id}`} question={`Make revision ${id} the newest one, in place of what has been mapped since?`} yes="Restore it" no="Leave it" busy={isPending} act={() => mutate('restore')} />
      )}
    </section>
  );
}

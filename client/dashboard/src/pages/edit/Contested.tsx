// SPDX-License-Identifier: Apache-2.0
import { useMutation, useQuery, useQueryClient } from '@tanstack/react-query';
import { useState, type FormEvent } from 'react';
import { mapEdits } from '../../api/clients';
import { idOf } from '../../api/names';
import { addressOf, Link } from '../../app/router';
import { LatticeFrame } from '../../edit/frame';
import { listed, valueNames } from '../../edit/words';
import type { Value } from '../../edit/cells';
import type { ContestedEdit } from '../../gen/enfilade/v1/map_edit_pb';
import { ContestSettlement_Choice as Choice } from '../../gen/enfilade/v1/map_edit_service_pb';
import { useLive } from '../../live/context';
import { count } from '../../ui/format';
import { refusalOf } from '../../ui/Sending';
import { author } from './author';

const POLL_MS = 15_000;

const keyOf = ({ box, session }: ContestedEdit) => `${session} ${box?.firstColumn},${box?.firstRow},${box?.width},${box?.height}`;
const word = (value: number) => (valueNames[value as Value] ?? 'something else').toLowerCase();

interface ItemProps {
  edit: ContestedEdit;
  choice: Choice | undefined;
  choose: (choice: Choice | undefined) => void;
  show: ((edit: ContestedEdit) => void) | undefined;
}

function Item({ edit, choice, choose, show }: ItemProps) {
  const live = useLive();
  const { box, lattice, session, cells, edited, seen, authors, message } = edit;
  const where = box && new LatticeFrame(lattice).place(box);
  return (
    <li className="edit-item">
      <p>
        {listed(authors)} made it <strong>{word(edited)}</strong>
        {message !== '' && ` (“${message}”)`}; a robot saw it <strong>{word(seen)}</strong> since: {count(Number(cells), 'cell')}, {where}.{' '}
        {session !== '' && <Link href={addressOf(live.id, 'sessions', [idOf(session)])}>Session</Link>}
      </p>
      <div className="edit-choices" role="group" aria-label={`What holds at ${where}`}>
        {show && (
          <button className="button small-text" type="button" onClick={() => show(edit)}>
            Show
          </button>
        )}
        {([[Choice.KEEP, 'Keep the edit'], [Choice.DROP, 'Show what robots see']] as const).map(([value, title]) => (
          <button key={value} className="button small-text" type="button" aria-pressed={choice === value} onClick={() => choose(choice === value ? undefined : value)}>
            {title}
          </button>
        ))}
      </div>
    </li>
  );
}

// Published edits that robots contest: they hold until a person settles them. `show`: where there is a picture of the map.
export function Contested({ map, show }: { map: string; show?: (edit: ContestedEdit) => void }) {
  const queries = useQueryClient();
  const live = useLive();
  const [choices, setChoices] = useState<ReadonlyMap<string, Choice>>(new Map());
  const [message, setMessage] = useState('');
  const key = ['contested', map, live.rasters.get(map)?.revision];
  const { data = [], error } = useQuery({ queryKey: key, refetchInterval: POLL_MS, queryFn: async () => (await mapEdits.listContestedEdits({ parent: map })).contested });
  const chosen = data.filter((edit) => choices.has(keyOf(edit)));
  const settle = useMutation({
    mutationFn: () => mapEdits.settleContestedEdits({
      parent: map, message: message.trim(), author: author.get(),
      settlements: chosen.map((edit) => ({ session: edit.session, choice: choices.get(keyOf(edit))!, ...(edit.box && { box: edit.box }) })),
    }),
    onSuccess: () => {
      setChoices(new Map());
      setMessage('');
    },
    onSettled: () => queries.invalidateQueries({ queryKey: key }),
  });
  const choose = (edit: ContestedEdit, choice: Choice | undefined) => {
    const next = new Map(choices);
    if (choice === undefined) next.delete(keyOf(edit));
    else next.set(keyOf(edit), choice);
    setChoices(next);
  };
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    settle.mutate();
  };
  return (
    <section className="inspector-part" aria-label="Contested edits">
      <h2>
        Contested edits <span className="sub">{data.length}</span>
      </h2>
      {error && <p className="refusal" role="alert">{refusalOf(error)}</p>}
      {data.length === 0 && !error && <p className="sub">None: robots have seen nothing that contradicts a published edit.</p>}
      <ul>
        {data.map((edit) => (
          <Item key={keyOf(edit)} edit={edit} choice={choices.get(keyOf(edit))} choose={(choice) => choose(edit, choice)} show={show} />
        ))}
      </ul>
      {data.length > 0 && (
        <form className="edit-settle" aria-label="Settle" onSubmit={onSubmit} noValidate>
          <label>
            Why
            <input className="field" maxLength={500} value={message} onChange={(event) => setMessage(event.target.value)} />
          </label>
          <button className="button" disabled={chosen.length === 0 || message.trim() === '' || settle.isPending}>
            Settle {count(chosen.length, 'place')}
          </button>
        </form>
      )}
      {settle.error && <p className="refusal" role="alert">{refusalOf(settle.error)}</p>}
      {settle.data?.revision && <p role="status">Settled: revision {idOf(settle.data.revision.name)}.</p>}
    </section>
  );
}

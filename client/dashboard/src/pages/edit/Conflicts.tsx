// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';
import type { LatticeFrame } from '../../edit/frame';
import type { Box } from '../../edit/lattice';
import { listed } from '../../edit/words';
import { MapEditResolution_Choice as Choice, type CheckMapDraftResponse } from '../../gen/enfilade/v1/map_edit_service_pb';
import { count } from '../../ui/format';

// By conflict.
export type Choices = readonly (Choice | undefined)[];

interface Props {
  check: CheckMapDraftResponse;
  frame: LatticeFrame;
  isBusy: boolean;
  show: (box: Box) => void;
  resolve: (choices: Choices) => void;
}

// Places where the draft and a publication since it began differ: a person says for each which one holds.
export function Conflicts({ check, frame, isBusy, show, resolve }: Props) {
  const [choices, setChoices] = useState<Choices>(check.conflicts.map(() => undefined));
  return (
    <section className="inspector-part" aria-label="Conflicts">
      <h2>
        {count(check.conflicts.length, 'place')} where somebody else has published something different since this draft began
      </h2>
      <ul>
        {check.conflicts.map(({ box, cells, myAuthors, theirAuthors }, i) => (
          <li key={i} className="edit-item">
            <fieldset className="edit-values">
              <legend>
                {count(Number(cells), 'cell')}
                {box && `, ${frame.place(box)}`}
              </legend>
              {([[Choice.MINE, 'This draft', myAuthors], [Choice.THEIRS, 'What is published', theirAuthors]] as const).map(([choice, title, authors]) => (
                <label key={choice}>
                  <input type="radio" name={`conflict-${i}`} checked={choices[i] === choice} onChange={() => setChoices(choices.map((other, k) => (k === i ? choice : other)))} /> {title}, by {listed(authors)}
                </label>
              ))}
              {box && (
                <button className="button small-text" type="button" onClick={() => show(box)}>
                  Show
                </button>
              )}
            </fieldset>
          </li>
        ))}
      </ul>
      <button className="button" disabled={isBusy || choices.some((choice) => choice === undefined)} onClick={() => resolve(choices)}>
        Settle the conflicts
      </button>
    </section>
  );
}

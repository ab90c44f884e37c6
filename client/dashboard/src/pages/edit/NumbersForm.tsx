// SPDX-License-Identifier: Apache-2.0
import { useState, type FormEvent } from 'react';
import { editsOf, type Measure, type NumberShape } from '../../edit/numbers';
import { author } from './author';
import type { EditorState } from './useEditor';

const shapes: Record<NumberShape, [title: string, points: string, example: string]> = {
  line: ['Line', 'Points', '0, 0; 2.5, 0'],
  rectangle: ['Rectangle', 'Two opposite corners', '0, 0; 2.5, 1'],
  polygon: ['Polygon', 'Corners', '0, 0; 2, 0; 1, 1.5'],
  dot: ['Dot of the brush', 'Place', '1.5, 2'],
  fill: ['Fill', 'Place', '1.5, 2'],
};

// All that the pointer draws, by numbers and keys.
export function NumbersForm({ editor }: { editor: EditorState }) {
  const { session, settings } = editor;
  const [shape, setShape] = useState<NumberShape>('line');
  const [measure, setMeasure] = useState<Measure>('metres');
  const [text, setText] = useState('');
  const [said, setSaid] = useState<{ text: string; isProblem: boolean }>();
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    const { value, onlyWhere, invisible } = settings.get();
    const edits = editsOf({ shape, measure, text }, session.frame, session.box, settings.get(), { value, onlyWhere, invisible, author: author.get() });
    const problem = typeof edits === 'string' ? edits : session.add(edits);
    setSaid(problem === undefined ? { text: `Drawn: ${shapes[shape][0].toLowerCase()}.`, isProblem: false } : { text: problem, isProblem: true });
  };
  const [, label, example] = shapes[shape];
  return (
    <details className="edit-details">
      <summary>Draw by numbers</summary>
      <form className="edit-numbers" aria-label="Draw by numbers" onSubmit={onSubmit} noValidate>
        <label>
          Shape
          <select className="select" value={shape} onChange={(event) => setShape(event.target.value as NumberShape)}>
            {(Object.keys(shapes) as NumberShape[]).map((one) => (
              <option key={one} value={one}>
                {shapes[one][0]}
              </option>
            ))}
          </select>
        </label>
        <label>
          Measured in
          <select className="select" value={measure} onChange={(event) => setMeasure(event.target.value as Measure)}>
            <option value="metres">metres of the map</option>
            <option value="cells">cells (column, row)</option>
          </select>
        </label>
        <label className="wide">
          {label}
          <input className="field" placeholder={example} value={text} onChange={(event) => setText(event.target.value)} />
        </label>
        <button className="button" disabled={!session.isOpen}>
          Draw
        </button>
      </form>
      {said && (
        <p className={said.isProblem ? 'refusal' : 'sub'} role={said.isProblem ? 'alert' : 'status'}>
          {said.text}
        </p>
      )}
    </details>
  );
}

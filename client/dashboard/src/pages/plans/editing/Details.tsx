// SPDX-License-Identifier: Apache-2.0
import { useState, type FormEvent } from 'react';
import type { Point } from '../../../scene/camera';
import { count, metres } from '../../../ui/format';
import { lengthOf, mayRemove, wallsAt, withCornerMoved, withMeasure, withThickness, type Element, type Graph } from './graph';
import type { Act, Editing } from './useEditing';

// "6.20 m" with a scale, "124.0 units" without.
export const lengthText = ({ metresPerUnit }: Graph, units: number) => (metresPerUnit === undefined ? `${units.toFixed(1)} units` : metres(units * metresPerUnit));

// What is selected, in words.
export function textOf(graph: Graph, element: Element | undefined): string {
  if (!element) return '';
  if (element.kind === 'corner') return `Corner of ${count(wallsAt(graph, element.at).length, 'wall')}`;
  const line = element.kind === 'wall' ? graph.walls[element.index] : graph.doors[element.index];
  return line ? `${element.kind === 'wall' ? 'Wall' : 'Door'} of ${lengthText(graph, lengthOf(line))}` : '';
}

// Undefined: no number that is larger than 0, or with `mayBeZero` at least 0.
function numberIn(text: string, mayBeZero = false): number | undefined {
  const value = Number(text.trim().replace(',', '.'));
  return text.trim() !== '' && Number.isFinite(value) && (value > 0 || (mayBeZero && value === 0)) ? value : undefined;
}

interface NumberProps {
  label: string;
  begin: string;
  button: string;
  // Undefined: it cannot be taken.
  take: (text: string) => (() => void) | undefined;
}

function NumberForm({ label, begin, button, take }: NumberProps) {
  const [text, setText] = useState(begin);
  const taken = take(text);
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    taken?.();
  };
  return (
    <form className="board-form" onSubmit={onSubmit}>
      <label>
        {label}
        <input className="field" inputMode="decimal" value={text} onChange={(event) => setText(event.target.value)} />
      </label>
      <button className="button" disabled={!taken}>
        {button}
      </button>
    </form>
  );
}

function CornerForm({ at, move }: { at: Point; move: (to: Point) => void }) {
  const [x, setX] = useState(String(at.x));
  const [y, setY] = useState(String(at.y));
  const to = { x: Number(x), y: Number(y) };
  const mayMove = x.trim() !== '' && y.trim() !== '' && Number.isFinite(to.x) && Number.isFinite(to.y);
  const onSubmit = (event: FormEvent) => {
    event.preventDefault();
    if (mayMove) move(to);
  };
  return (
    <form className="board-form" aria-label="Place of the corner" onSubmit={onSubmit}>
      <label>
        x
        <input className="field" inputMode="decimal" value={x} onChange={(event) => setX(event.target.value)} />
      </label>
      <label>
        y
        <input className="field" inputMode="decimal" value={y} onChange={(event) => setY(event.target.value)} />
      </label>
      <button className="button" disabled={!mayMove}>
        Move
      </button>
    </form>
  );
}

// What is selected or measured, and what can be done with it.
// `leave`: where the focus goes when what has it vanishes.
export function Details({ state, act, leave }: { state: Editing; act: (act: Act) => void; leave: () => void }) {
  const { steps: { now }, selected, measured } = state;
  const to = (graph: Graph) => act({ kind: 'step', step: { to: graph } });
  if (measured) {
    return (
      <NumberForm label="Distance, m" begin="" button="Set the scale" take={(text) => {
        const length = numberIn(text);
        return length === undefined ? undefined : () => {
          to(withMeasure(now, measured.from, measured.to, length));
          leave();
        };
      }} />
    );
  }
  if (!selected) return <p className="sub">Nothing is selected.</p>;
  const wall = selected.kind === 'wall' ? now.walls[selected.index] : undefined;
  const index = selected.kind === 'wall' ? selected.index : -1;
  return (
    <div className="board-details">
      {wall && (
        <NumberForm key={`${index} ${wall.thickness}`} label="Thickness, units; 0: unknown" begin={String(wall.thickness)} button="Change" take={(text) => {
          const thickness = numberIn(text, true);
          return thickness === undefined || thickness === wall.thickness ? undefined : () => {
            to(withThickness(now, index, thickness));
            act({ kind: 'select', element: selected });
          };
        }} />
      )}
      {selected.kind === 'corner' && (
        <CornerForm key={`${selected.at.x} ${selected.at.y}`} at={selected.at} move={(place) => {
          to(withCornerMoved(now, selected.at, place));
          act({ kind: 'select', element: { kind: 'corner', at: place } });
        }} />
      )}
      <button className="button" disabled={!mayRemove(now, selected)} onClick={() => { act({ kind: 'remove' }); leave(); }}>
        Delete the {selected.kind}
      </button>
      {!mayRemove(now, selected) && <p className="sub">More than two walls meet here: delete walls, or move the corner.</p>}
    </div>
  );
}

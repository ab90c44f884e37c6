// SPDX-License-Identifier: Apache-2.0
import { useState } from 'react';

interface Props {
  label: string;
  value: number;
  digits: number;
  step: number;
  min?: number;
  max?: number;
  onChange: (value: number) => void;
}

// A number that holds as soon as it is one, while it is typed; what is none, or out of range, is marked and changes nothing.
export function NumberField({ label, value, digits, step, min = -Infinity, max = Infinity, onChange }: Props) {
  const [text, setText] = useState<string>();
  const fits = (given: number) => Number.isFinite(given) && given >= min && given <= max;
  const isWrong = text !== undefined && (text.trim() === '' || !fits(Number(text)));
  const take = (given: string) => {
    setText(given);
    if (given.trim() !== '' && fits(Number(given))) onChange(Number(given));
  };
  return (
    <label className="number-field">
      {label}
      <input className="field" type="number" step={step} min={Number.isFinite(min) ? min : undefined} max={Number.isFinite(max) ? max : undefined} aria-invalid={isWrong}
        value={text ?? String(Number(value.toFixed(digits)))} onChange={(event) => take(event.target.value)} onBlur={() => setText(undefined)} />
    </label>
  );
}

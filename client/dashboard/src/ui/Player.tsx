// SPDX-License-Identifier: Apache-2.0
import type { ReactNode } from 'react';
import { Icon } from './Icon';

interface Props {
  // Of the slider, for who does not see it: what it chooses, and what is chosen.
  label: string;
  text: string;
  value: number;
  max: number;
  step: number;
  onChange: (value: number) => void;
  playing: boolean;
  setPlaying: (on: boolean) => void;
  children?: ReactNode;
}

// A slider over time that plays. The keys are the slider's own: arrows, Page up and down, Home, End.
export function Player({ label, text, value, max, step, onChange, playing, setPlaying, children }: Props) {
  const what = playing ? 'Pause' : 'Play';
  return (
    <div className="player" role="group" aria-label={label}>
      <button className="button icon" aria-label={what} title={what} disabled={max <= 0} onClick={() => setPlaying(!playing)}>
        <Icon name={playing ? 'pause' : 'play'} />
      </button>
      <input
        type="range" min={0} max={max} step={step} value={value} aria-label={label} aria-valuetext={text} disabled={max <= 0}
        onChange={(event) => {
          setPlaying(false);
          onChange(Number(event.target.value));
        }}
      />
      <output className="player-text">{text}</output>
      {children}
    </div>
  );
}

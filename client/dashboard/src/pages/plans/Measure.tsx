// SPDX-License-Identifier: Apache-2.0
import { useEffect, useState } from 'react';
import type { Point } from '../../scene/camera';
import { Sheet } from './Sheet';

interface Props {
  file: File;
  // Two at most.
  points: Point[];
  show: (points: Point[]) => void;
  metres: string;
  setMetres: (metres: string) => void;
}

// A distance that is known, clicked in a picture that is not sent yet. Without one the scale is found by the maps.
export function Measure({ file, points, show, metres, setMetres }: Props) {
  const [isOpen, setOpen] = useState(false);
  const [src, setSrc] = useState<string>();
  useEffect(() => {
    const url = URL.createObjectURL(file);
    setSrc(url);
    return () => URL.revokeObjectURL(url);
  }, [file]);
  return (
    <details className="plan-measure" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>Give a known distance</summary>
      <p className="sub">Click two points whose distance you know, such as the ends of a wall. It tells the scale.</p>
      {isOpen && src !== undefined && <Sheet src={src} points={points} chosen={undefined} choose={(point) => show(points.length === 2 ? [point] : [...points, point])} />}
      <label>
        Metres between the points
        <input className="field" inputMode="decimal" value={metres} disabled={points.length < 2} onChange={(event) => setMetres(event.target.value)} />
      </label>
      {points.length > 0 && (
        <button className="button" type="button" onClick={() => show([])}>
          Take the points back
        </button>
      )}
    </details>
  );
}

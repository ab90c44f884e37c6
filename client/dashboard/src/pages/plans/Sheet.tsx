// SPDX-License-Identifier: Apache-2.0
import { useRef, useState, type MouseEvent } from 'react';
import type { Point } from '../../scene/camera';
import { inPicture, onSheet } from './pairs';

// The imported picture, with points on it: those of pairs by their numbers, and the one that is being chosen.
export function Sheet({ src, points, chosen, choose }: { src: string; points: Point[]; chosen: Point | undefined; choose: (point: Point) => void }) {
  const image = useRef<HTMLImageElement>(null);
  const [size, setSize] = useState<{ naturalWidth: number; naturalHeight: number }>();
  const [zoom, setZoom] = useState(1);
  const onClick = ({ clientX, clientY }: MouseEvent) => {
    if (image.current && size) choose(onSheet(size, image.current.getBoundingClientRect(), { x: clientX, y: clientY }));
  };
  const mark = (point: Point, text: string, kind: string) => {
    if (!size) return null;
    const { x, y } = inPicture(size, point);
    return (
      <span key={text} className={`sheet-point ${kind}`} style={{ left: `${x}%`, top: `${y}%` }} aria-hidden="true">
        <span>{text}</span>
      </span>
    );
  };
  return (
    <div className="sheet">
      <label className="sheet-zoom">
        Zoom
        <input type="range" min={1} max={8} step={0.5} value={zoom} onChange={(event) => setZoom(Number(event.target.value))} />
      </label>
      <div className="sheet-window" tabIndex={0} role="region" aria-label="Sheet">
        <div className="sheet-picture" style={{ width: `${100 * zoom}%` }}>
          <img ref={image} src={src} alt="The imported plan" onLoad={({ currentTarget: { naturalWidth, naturalHeight } }) => setSize({ naturalWidth, naturalHeight })} onClick={onClick} />
          {points.map((point, i) => mark(point, String(i + 1), 'shown'))}
          {chosen && mark(chosen, '', 'chosen')}
        </div>
      </div>
    </div>
  );
}

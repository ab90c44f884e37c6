// SPDX-License-Identifier: Apache-2.0
// The outline of an area that is edited, over the map: its corners are moved, taken away and added, by pointer or keys.
import { useEffect, useRef, useState, useSyncExternalStore } from 'react';
import { screenToWorld, worldToScreen, type Point } from '../../scene/camera';
import { Grip } from '../../ui/Grip';
import type { EditorState } from './useEditor';

// More would hide the map: these are typed.
const MOST = 200;

const steps: Record<string, [dx: number, dy: number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export function AreaHandles({ editor }: { editor: EditorState }) {
  const { board, session: { frame }, outline } = editor;
  const camera = useSyncExternalStore(board.cameraChanged.subscribe, () => board.camera);
  const grabbed = useRef<{ from: Point; at: Point; index: number; before: readonly Point[]; outline: readonly Point[] }>(undefined);
  const host = useRef<HTMLDivElement>(null);
  const [focus, setFocus] = useState<number>();
  useEffect(() => {
    if (focus !== undefined) host.current?.querySelectorAll<HTMLElement>('.grip.corner')[focus]?.focus();
    setFocus(undefined);
  }, [focus]);
  if (!outline || outline.length > MOST) return null;
  const { size } = board;
  const set = (corners: readonly Point[]) => editor.set({ outline: corners });
  const screenOf = (corner: Point) => worldToScreen(camera, size, frame.cells(corner));
  const middleOf = (i: number): Point => {
    const [a, b] = [outline[i]!, outline[(i + 1) % outline.length]!];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
  };
  const withMiddle = (i: number) => [...outline.slice(0, i + 1), middleOf(i), ...outline.slice(i + 1)];

  const begin = (index: number, from: Point, corners = outline) => {
    grabbed.current = { from, at: screenOf(corners[index]!), index, before: outline, outline: corners };
  };
  // The pointer keeps the place of the corner where it took it.
  const drag = (to: Point) => {
    const it = grabbed.current;
    if (!it) return;
    const corner = frame.metres(screenToWorld(camera, size, { x: it.at.x + to.x - it.from.x, y: it.at.y + to.y - it.from.y }));
    set(it.outline.map((other, i) => (i === it.index ? corner : other)));
  };
  const end = (cancelled: boolean) => {
    if (cancelled && grabbed.current) set(grabbed.current.before);
    grabbed.current = undefined;
  };
  const step = (index: number, key: string, fine: boolean): boolean => {
    if (key === 'Delete' && outline.length > 3) {
      set(outline.filter((_, i) => i !== index));
      setFocus(Math.min(index, outline.length - 2));
      return true;
    }
    const by = steps[key];
    if (!by) return false;
    const { x, y } = frame.cells(outline[index]!);
    const cells = fine ? 0.1 : 1;
    set(outline.map((other, i) => (i === index ? frame.metres({ x: x + by[0] * cells, y: y + by[1] * cells }) : other)));
    return true;
  };
  const split = (index: number, key: string): boolean => {
    if (key !== 'Enter' && key !== ' ') return false;
    set(withMiddle(index));
    setFocus(index + 1);
    return true;
  };
  // Who goes through the corners by keys sees each.
  const show = (corner: Point) => {
    const { x, y } = screenOf(corner);
    if (x < 0 || y < 0 || x > size.width || y > size.height) board.setCamera({ ...frame.cells(corner), scale: camera.scale });
  };
  const common = { canvas: () => board.canvas, drag, end };
  const styleOf = (corner: Point) => {
    const { x, y } = screenOf(corner);
    return { transform: `translate(${x}px, ${y}px) translate(-50%, -50%)` };
  };
  return (
    <div ref={host} role="group" aria-label="Outline of the area">
      {outline.map((corner, i) => (
        <Grip key={`corner ${i}`} {...common} className="corner" label={`Corner ${i + 1} at ${corner.x.toFixed(2)}, ${corner.y.toFixed(2)} m. Arrow keys move it, Delete takes it away.`} style={styleOf(corner)}
          begin={(from) => begin(i, from)} step={(key, fine) => step(i, key, fine)} focused={() => show(corner)} />
      ))}
      {outline.length >= 3 && outline.map((_, i) => (
        <Grip key={`side ${i}`} {...common} className="side" label={`Side ${i + 1}. Enter adds a corner in its middle.`} style={styleOf(middleOf(i))}
          begin={(from) => begin(i + 1, from, withMiddle(i))} step={(key) => split(i, key)} focused={() => show(middleOf(i))} />
      ))}
    </div>
  );
}

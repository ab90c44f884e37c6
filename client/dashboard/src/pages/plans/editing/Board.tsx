// SPDX-License-Identifier: Apache-2.0
import { useEffect, useLayoutEffect, useRef, useState, type KeyboardEvent, type PointerEvent, type RefObject } from 'react';
import type { Point } from '../../../scene/camera';
import { cornersOf, elementAt, type Element, type Graph } from './graph';
import { meant, tools, type Act, type Editing } from './useEditing';

// What of the sheet is shown, in its units.
export interface Frame {
  x: number;
  y: number;
  width: number;
  height: number;
}

const REACH_PX = 9;
const DRAG_PX = 4;
const STEP_PX = 10;
const MOST_ZOOM = 16;

const lines = (all: readonly { from: Point; to: Point }[]) => all.map(({ from, to }) => `M${from.x} ${from.y}L${to.x} ${to.y}`).join('');
const dots = (all: readonly Point[]) => all.map(({ x, y }) => `M${x} ${y}h0`).join('');

function Selected({ graph, element }: { graph: Graph; element: Element }) {
  if (element.kind === 'corner') return <path className="board-corner selected" d={dots([element.at])} />;
  const line = element.kind === 'wall' ? graph.walls[element.index] : graph.doors[element.index];
  return line ? <path className="board-line selected" d={lines([line])} /> : null;
}

// What the next click would make.
function Preview({ state, reach }: { state: Editing; reach: number }) {
  const { steps: { now }, first, measured, grabbed, at, tool } = state;
  if (measured) return <path className="board-line preview" d={lines([measured])} />;
  if (!at || (tool === 'select' && !grabbed)) return null;
  const to = meant(state, at, reach);
  const own = grabbed ? now.walls.filter(({ from, to: end }) => (from.x === grabbed.x && from.y === grabbed.y) || (end.x === grabbed.x && end.y === grabbed.y)) : [];
  const moved = own.map(({ from, to: end }) => ({ from: from.x === grabbed!.x && from.y === grabbed!.y ? end : from, to }));
  return (
    <>
      <path className="board-line preview" d={lines(first ? [{ from: first, to }] : moved)} />
      <path className="board-corner preview" d={dots([to])} />
    </>
  );
}

interface Props {
  state: Editing;
  act: (act: Act) => void;
  frame: Frame;
  picture: string | undefined;
  // Of what is selected.
  said: string;
  // The window on the sheet, which keys go to.
  board: RefObject<HTMLDivElement | null>;
}

// The sheet with the walls over it. All that a pointer does, keys do as well.
export function Board({ state, act, frame, picture, said, board }: Props) {
  const [zoom, setZoom] = useState(1);
  // Pixels: the width at which all of the sheet is in sight.
  const [fit, setFit] = useState(0);
  const [isFocused, setFocused] = useState(false);
  const pressed = useRef<{ x: number; y: number; corner: Point | undefined }>(undefined);
  const { steps: { now }, selected, grabbed, at } = state;
  const unitsPerPx = fit > 0 ? frame.width / (fit * zoom) : 1;
  const reach = REACH_PX * unitsPerPx;

  useLayoutEffect(() => {
    const element = board.current!;
    const watch = new ResizeObserver(([entry]) => {
      const { width, height } = entry!.contentRect;
      setFit(Math.min(width, (height * frame.width) / frame.height));
    });
    watch.observe(element.parentElement!);
    return () => watch.disconnect();
  }, [board, frame]);

  // What is in the middle stays there.
  const zoomTo = (next: number) => {
    const { scrollLeft, scrollTop, clientWidth, clientHeight } = board.current!;
    const factor = next / zoom;
    setZoom(next);
    requestAnimationFrame(() => board.current?.scrollTo((scrollLeft + clientWidth / 2) * factor - clientWidth / 2, (scrollTop + clientHeight / 2) * factor - clientHeight / 2));
  };

  // The cross stays in sight.
  useEffect(() => {
    const element = board.current!;
    if (!at || !isFocused) return;
    const [x, y] = [(at.x - frame.x) / unitsPerPx, (at.y - frame.y) / unitsPerPx];
    const margin = 24;
    const left = Math.min(Math.max(element.scrollLeft, x + margin - element.clientWidth), x - margin);
    const top = Math.min(Math.max(element.scrollTop, y + margin - element.clientHeight), y - margin);
    if (left !== element.scrollLeft || top !== element.scrollTop) element.scrollTo(left, top);
  }, [board, at, isFocused, frame, unitsPerPx]);

  const placeOfEvent = ({ clientX, clientY, currentTarget }: PointerEvent<SVGSVGElement>): Point => {
    const box = currentTarget.getBoundingClientRect();
    return { x: frame.x + ((clientX - box.left) / box.width) * frame.width, y: frame.y + ((clientY - box.top) / box.height) * frame.height };
  };
  const reachOf = ({ altKey }: { altKey: boolean }) => (altKey ? 0 : reach);

  const onDown = (event: PointerEvent<SVGSVGElement>) => {
    if (event.button !== 0) return;
    const element = state.tool === 'select' ? elementAt(now, placeOfEvent(event), reach) : undefined;
    pressed.current = { x: event.clientX, y: event.clientY, corner: element?.kind === 'corner' ? element.at : undefined };
    event.currentTarget.setPointerCapture(event.pointerId);
  };
  const onMove = (event: PointerEvent<SVGSVGElement>) => {
    const from = pressed.current;
    if (from?.corner && !grabbed && Math.hypot(event.clientX - from.x, event.clientY - from.y) > DRAG_PX) act({ kind: 'grab', corner: from.corner });
    if (state.tool !== 'select' || grabbed || from?.corner) act({ kind: 'move', at: placeOfEvent(event) });
  };
  const onUp = (event: PointerEvent<SVGSVGElement>) => {
    if (!pressed.current) return;
    pressed.current = undefined;
    act({ kind: grabbed ? 'drop' : 'click', at: placeOfEvent(event), reach: reachOf(event) });
  };

  const onKey = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.metaKey || event.target !== board.current) return;
    const step = (event.shiftKey ? 1 : STEP_PX) * unitsPerPx;
    const cross = at ?? { x: frame.x + frame.width / 2, y: frame.y + frame.height / 2 };
    const moves: Record<string, [number, number]> = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    const move = moves[event.key];
    if (move) act({ kind: 'move', at: { x: cross.x + move[0], y: cross.y + move[1] } });
    else if (event.key === 'Enter' || event.key === ' ') act({ kind: 'click', at: cross, reach: reachOf(event) });
    else if (event.key === 'n') act({ kind: 'next', step: 1 });
    else if (event.key === 'N') act({ kind: 'next', step: -1 });
    else if (event.key === '+' || event.key === '=') zoomTo(Math.min(MOST_ZOOM, zoom * 2));
    else if (event.key === '-') zoomTo(Math.max(1, zoom / 2));
    else return;
    event.preventDefault();
  };

  return (
    <div className="board">
      <label className="board-zoom">
        Zoom
        <input type="range" min={1} max={MOST_ZOOM} step={0.5} value={zoom} onChange={(event) => zoomTo(Number(event.target.value))} />
      </label>
      <div className="board-place">
        <div ref={board} className="board-window" tabIndex={0} role="application" aria-describedby="board-hint"
          aria-label="Sheet with its walls. Arrow keys move the cross, Shift makes small steps, Enter clicks there, n and Shift+n go from one wall, door or corner to the next, Delete removes, plus and minus zoom."
          onKeyDown={onKey} onFocus={() => setFocused(true)} onBlur={() => setFocused(false)}>
          <svg viewBox={`${frame.x} ${frame.y} ${frame.width} ${frame.height}`} style={{ width: fit * zoom, height: (fit * zoom * frame.height) / frame.width }}
            preserveAspectRatio="none" aria-hidden="true" data-tool={state.tool} onPointerDown={onDown} onPointerMove={onMove} onPointerUp={onUp}>
            {picture !== undefined && <image href={picture} x={frame.x} y={frame.y} width={frame.width} height={frame.height} preserveAspectRatio="none" />}
            <path className="board-line wall" d={lines(now.walls)} />
            <path className="board-line door" d={lines(now.doors)} />
            <path className="board-corner" d={dots(cornersOf(now))} />
            {selected && !grabbed && <Selected graph={now} element={selected} />}
            <Preview state={state} reach={reach} />
            {isFocused && at && <path className="board-cross" d={`M${at.x - reach} ${at.y}h${2 * reach}M${at.x} ${at.y - reach}v${2 * reach}`} />}
          </svg>
        </div>
      </div>
      <p className="board-hint">
        <span id="board-hint" className="sub">{tools.find(({ tool }) => tool === state.tool)!.hint}</span>
        <strong role="status">{said}</strong>
      </p>
    </div>
  );
}

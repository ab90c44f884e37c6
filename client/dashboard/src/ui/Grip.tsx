// SPDX-License-Identifier: Apache-2.0
// What a person grabs over the map, by pointer or by the arrow keys.
import './grip.css';
import { useRef, type CSSProperties, type KeyboardEvent, type PointerEvent, type ReactNode } from 'react';

interface Point {
  x: number;
  y: number;
}

interface Props {
  // What it is and where it stands, for who does not see it.
  label: string;
  className: string;
  style: CSSProperties;
  // The map below.
  canvas: () => HTMLElement | undefined;
  // In CSS pixels of the canvas; `at`: of the pointer.
  begin: (at: Point) => void;
  drag: (at: Point) => void;
  // `cancelled`: all is to be as it was.
  end: (cancelled: boolean) => void;
  // An arrow key; `fine` with Shift. False: it does nothing here.
  step: (key: string, fine: boolean) => boolean;
  focused?: () => void;
  children?: ReactNode;
}

export function Grip({ label, className, style, canvas, begin, drag, end, step, focused, children }: Props) {
  const grabbed = useRef<number>(undefined);
  const onCanvas = ({ clientX, clientY }: PointerEvent): Point => {
    const { left = 0, top = 0 } = canvas()?.getBoundingClientRect() ?? {};
    return { x: clientX - left, y: clientY - top };
  };
  const finish = (cancelled: boolean) => {
    if (grabbed.current === undefined) return;
    grabbed.current = undefined;
    end(cancelled);
  };
  const onPointerDown = (event: PointerEvent<HTMLButtonElement>) => {
    if (event.button !== 0) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    grabbed.current = event.pointerId;
    begin(onCanvas(event));
  };
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.key === 'Escape' && grabbed.current !== undefined) finish(true);
    else if (event.ctrlKey || event.metaKey || event.altKey || !step(event.key, event.shiftKey)) return;
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <button type="button" className={`grip ${className}`} aria-label={label} title={label} style={style} onPointerDown={onPointerDown} onKeyDown={onKeyDown} onFocus={focused}
      onPointerMove={(event) => grabbed.current === event.pointerId && drag(onCanvas(event))} onPointerUp={() => finish(false)} onPointerCancel={() => finish(true)}
      // The wheel zooms the map below.
      onWheel={(event) => canvas()?.dispatchEvent(new WheelEvent('wheel', event.nativeEvent))}>
      {children}
    </button>
  );
}

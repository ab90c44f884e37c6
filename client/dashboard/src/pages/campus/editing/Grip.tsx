// SPDX-License-Identifier: Apache-2.0
// What a person grabs over the map, by pointer or by the arrow keys.
import { useRef, type CSSProperties, type KeyboardEvent, type PointerEvent, type ReactNode } from 'react';
import type { Point } from '../../../scene/camera';
import { sharedScene } from '../../../scene/shared';

interface Props {
  // What it is and where it stands, for who does not see it.
  label: string;
  className: string;
  style: CSSProperties;
  // In CSS pixels of the canvas; `at`: of the pointer.
  begin: (at: Point) => void;
  drag: (at: Point) => void;
  // `cancelled`: all is to be as it was.
  end: (cancelled: boolean) => void;
  // An arrow key; `fine` with Shift. False: it does nothing here.
  step: (key: string, fine: boolean) => boolean;
  children?: ReactNode;
}

function onCanvas({ clientX, clientY }: PointerEvent): Point {
  const box = sharedScene()!.canvas.getBoundingClientRect();
  return { x: clientX - box.left, y: clientY - box.top };
}

export function Grip({ label, className, style, begin, drag, end, step, children }: Props) {
  const grabbed = useRef<number>(undefined);
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
    <button type="button" className={`grip ${className}`} aria-label={label} title={label} style={style} onPointerDown={onPointerDown} onKeyDown={onKeyDown}
      onPointerMove={(event) => grabbed.current === event.pointerId && drag(onCanvas(event))} onPointerUp={() => finish(false)} onPointerCancel={() => finish(true)}
      // The wheel zooms the map below.
      onWheel={(event) => sharedScene()?.canvas.dispatchEvent(new WheelEvent('wheel', event.nativeEvent))}>
      {children}
    </button>
  );
}

// SPDX-License-Identifier: Apache-2.0
import { useCallback, useEffect, useRef, useState, type KeyboardEvent } from 'react';
import { converterOf, inWorld, latLonText, useGeoreference } from '../../geo/georeference';
import { useLive } from '../../live/context';
import { titleOf } from '../../live/objects';
import type { Point } from '../../scene/camera';
import { sharedScene } from '../../scene/shared';
import { copy, NOT_COPIED } from '../../ui/clipboard';

// A place in the frame that the page shows.
interface ChosenPoint {
  at: Point;
  screen: Point;
}

interface Coordinates {
  frame: string;
  text: string;
}

const xyText = ({ x, y }: Point) => `${x.toFixed(3)} ${y.toFixed(3)}`;

// The place in each frame that is known: the map's, the world's, and the globe's.
function useCoordinates(at: Point, ownMap: string | undefined): Coordinates[] {
  const site = useLive();
  const scene = sharedScene();
  const { data } = useGeoreference(site);
  const map = ownMap ?? scene?.mapAt(at);
  const inMap = map === undefined || ownMap !== undefined ? at : scene?.inMap(map, at);
  const world = ownMap === undefined ? at : inWorld(site, { map: ownMap, ...at });
  const found: Coordinates[] = [];
  if (world) found.push({ frame: 'in the world', text: xyText(world) });
  if (map !== undefined && inMap) found.push({ frame: `in ${titleOf(site, map)}`, text: xyText(inMap) });
  const place = world && converterOf(site, data)?.(world);
  if (place) found.push({ frame: 'on the globe', text: latLonText(place) });
  return found;
}

function PointMenu({ point: { at, screen }, map, copied, close }: { point: ChosenPoint; map: string | undefined; copied: (text: string) => void; close: () => void }) {
  const menu = useRef<HTMLDivElement>(null);
  const coordinates = useCoordinates(at, map);
  const leave = () => {
    close();
    sharedScene()?.canvas.focus();
  };
  useEffect(() => {
    menu.current?.querySelector<HTMLElement>('[role=menuitem]')?.focus();
    const onDown = (event: PointerEvent) => !menu.current?.contains(event.target as Node) && close();
    document.addEventListener('pointerdown', onDown, true);
    return () => document.removeEventListener('pointerdown', onDown, true);
  }, [at, close]);
  const onKeyDown = (event: KeyboardEvent) => {
    const items = [...(menu.current?.querySelectorAll<HTMLElement>('[role=menuitem]') ?? [])];
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step !== undefined) items.at((items.indexOf(document.activeElement as HTMLElement) + step) % items.length)?.focus();
    else if (event.key === 'Escape' || event.key === 'Tab') leave();
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div className="point-menu" role="menu" aria-label="Copy the coordinates of this place" tabIndex={-1} ref={menu} onKeyDown={onKeyDown}
      style={{ left: `min(${screen.x}px, 100% - 288px)`, top: `min(${screen.y}px, 100% - ${40 + 32 * coordinates.length}px)` }}>
      <p className="sub">Copy coordinates</p>
      {coordinates.map(({ frame, text }) => (
        <button key={frame} role="menuitem" onClick={() => (copied(text), leave())}>
          <span className="mono">{text}</span> <span className="sub">{frame}</span>
        </button>
      ))}
    </div>
  );
}

const SAID_MS = 3000;

// The menu at a place of the map, which copies its coordinates, and what it has done. `map`: the page shows this map only,
// in its own frame.
export function usePointMenu(map?: string) {
  const [point, setPoint] = useState<ChosenPoint>();
  const [said, setSaid] = useState('');
  useEffect(() => {
    if (said === '') return;
    const timer = setTimeout(() => setSaid(''), SAID_MS);
    return () => clearTimeout(timer);
  }, [said]);
  const close = useCallback(() => setPoint(undefined), []);
  const copied = async (text: string) => setSaid((await copy(text)) ? `Copied ${text}` : NOT_COPIED);
  return {
    said,
    open: (at: Point, screen: Point) => setPoint({ at, screen }),
    menu: point && <PointMenu point={point} map={map} copied={(text) => void copied(text)} close={close} />,
  };
}

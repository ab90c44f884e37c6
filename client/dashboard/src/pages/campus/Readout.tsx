// SPDX-License-Identifier: Apache-2.0
import { useImperativeHandle, useRef, useState, type Ref } from 'react';
import { collectionOf, idOf } from '../../api/names';
import { useLive } from '../../live/context';
import { stateOf, titleOf } from '../../live/objects';
import type { LiveSite } from '../../live/site';
import type { Point } from '../../scene/camera';
import { sharedScene, useScale } from '../../scene/shared';
import { degrees, metres, pose } from '../../ui/format';

export interface ReadoutHandle {
  hover(what: string | undefined, world: Point | undefined, screen: Point | undefined): void;
}

interface Card {
  title: string;
  lines: string[];
}

// The standard deviations of a covariance [xx, xy, yy, yaw].
export const sigma = (c: ArrayLike<number>) => `± ${metres(Math.sqrt(Math.max(c[0]!, c[2]!)))}, ${degrees(Math.sqrt(c[3]!))}`;

export function cardOf(site: LiveSite, name: string): Card | undefined {
  const robot = site.robots.get(name);
  if (robot) return { title: idOf(name), lines: [`in ${titleOf(site, robot.map)}`, pose(robot.poseWorld ?? robot.poseMap), sigma(robot.covariance)] };
  const link = site.linkPoints.get(name);
  if (link) return { title: titleOf(site, name), lines: [stateOf(link).text, idOf(name)] };
  const map = site.maps.get(name);
  const c = map?.poseWorldMap?.covariance;
  return map && { title: map.displayName, lines: [map.map === site.rootMap ? 'The root: its frame is the world frame' : c?.length === 9 ? sigma([c[0]!, c[1]!, c[4]!, c[8]!]) : 'not placed'] };
}

const steps = [1, 2, 5];

// A round length that is 60 to 150 pixels long.
export function scaleBar(pixelsPerMetre: number): { metres: number; pixels: number } {
  const wanted = 60 / pixelsPerMetre;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = [...steps, 10].map((step) => step * power).find((value) => value >= wanted) ?? wanted;
  return { metres: length, pixels: length * pixelsPerMetre };
}

const lengthText = (value: number) => (value >= 1000 ? `${value / 1000} km` : value >= 1 ? `${value} m` : `${Math.round(value * 100)} cm`);

// Coordinates, what is under the pointer, the scale, and what the page has to say. It changes with the pointer, so it is a component of its own.
export function Readout({ ref, said }: { ref: Ref<ReadoutHandle>; said: string }) {
  const site = useLive();
  const [at, setAt] = useState<{ what: string | undefined; world: Point; screen: Point }>();
  const last = useRef(0);
  useImperativeHandle(ref, () => ({
    hover(what, world, screen) {
      const now = performance.now();
      if (world && now - last.current < 40) return;
      last.current = now;
      setAt(world && screen ? { what, world, screen } : undefined);
    },
  }));
  const scene = sharedScene();
  const bar = scaleBar(useScale());
  const card = at?.what === undefined ? undefined : cardOf(site, at.what);
  const map = at?.what !== undefined && collectionOf(at.what) === 'maps' ? at.what : undefined;
  const inMap = map !== undefined && at ? scene?.inMap(map, at.world) : undefined;
  return (
    <>
      {card && at && (
        <div className="hover-card" style={{ transform: `translate(${at.screen.x + 16}px, ${at.screen.y + 16}px)` }}>
          <strong>{card.title}</strong>
          {card.lines.map((line) => (
            <span key={line} className="sub">
              {line}
            </span>
          ))}
        </div>
      )}
      <div className="scene-status">
        <div className="scale-bar" style={{ width: bar.pixels }}>
          {lengthText(bar.metres)}
        </div>
        <span className="scene-chip mono">{at && `x ${at.world.x.toFixed(2)}  y ${at.world.y.toFixed(2)} m`}</span>
        <span className="scene-chip">{inMap && map !== undefined && `${titleOf(site, map)} ${inMap.x.toFixed(2)}, ${inMap.y.toFixed(2)} m`}</span>
        <span className="scene-chip" role="status">
          {said}
        </span>
      </div>
    </>
  );
}

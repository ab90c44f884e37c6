// SPDX-License-Identifier: Apache-2.0
// A map that is laid over another one by hand: it is dragged whole, and turned by a corner.
import { useRef } from 'react';
import { affineOf, apply } from '../../../scene/affine';
import { worldToScreen, type Point, type Pose } from '../../../scene/camera';
import { middleAt } from '../../../scene/moves';
import { thumbnailAffine } from '../../../scene/outlines';
import { Grip } from '../../../ui/Grip';
import { chained, relative, wrapped } from '../../../scene/se2';
import { sceneCanvas, useShown, useThumbnails } from '../../../scene/shared';
import { pose as poseText } from '../../../ui/format';

interface Props {
  map: string;
  title: string;
  // T_world_a, and the guess T_a_b.
  base: Pose;
  guess: Pose;
  change: (guess: Pose) => void;
}

const STEP_M = 0.1;
const STEP_RAD = Math.PI / 180;

export function AlignHandles({ map, title, base, guess, change }: Props) {
  const shown = useShown();
  const thumbnail = useThumbnails().get(map);
  const grabbed = useRef<{ from: Point; pose: Pose; middle: Point }>(undefined);
  if (!shown || !thumbnail) return null;
  const { camera, size } = shown;
  const place = chained(base, guess);
  const cells = thumbnailAffine(affineOf(place), thumbnail);
  const middle = middleAt(place, thumbnail);
  const at = worldToScreen(camera, size, middle);
  const corner = worldToScreen(camera, size, apply(cells, { x: thumbnail.width, y: thumbnail.height }));
  const scale = thumbnail.resolution * camera.scale;
  const set = (pose: Pose) => change(relative(base, pose));
  // About its middle, which is what a person looks at.
  const turned = ({ pose, middle: about }: { pose: Pose; middle: Point }, turn: number) => {
    const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
    const [dx, dy] = [pose.x - about.x, pose.y - about.y];
    set({ x: about.x + cos * dx - sin * dy, y: about.y + sin * dx + cos * dy, yaw: wrapped(pose.yaw + turn) });
  };
  const begin = (from: Point) => {
    grabbed.current = { from, pose: place, middle };
  };
  const end = (cancelled: boolean) => {
    if (cancelled && grabbed.current) set(grabbed.current.pose);
    grabbed.current = undefined;
  };
  const move = (to: Point) => {
    const it = grabbed.current;
    if (it) set({ ...it.pose, x: it.pose.x + (to.x - it.from.x) / camera.scale, y: it.pose.y - (to.y - it.from.y) / camera.scale });
  };
  const turn = (to: Point) => {
    const it = grabbed.current;
    if (!it) return;
    const about = worldToScreen(camera, size, it.middle);
    const direction = ({ x, y }: Point) => Math.atan2(about.y - y, x - about.x);
    turned(it, direction(to) - direction(it.from));
  };
  const text = poseText(guess);
  return (
    <>
      <Grip canvas={sceneCanvas} className="whole" label={`${title} at ${text}. Arrow keys move it.`} begin={begin} drag={move} end={end}
        style={{ width: thumbnail.width * scale, height: thumbnail.height * scale, transform: `translate(${at.x}px, ${at.y}px) translate(-50%, -50%) rotate(${-Math.atan2(cells.b, cells.a)}rad)` }}
        step={(key, fine) => {
          const [dx, dy] = [{ ArrowLeft: -1, ArrowRight: 1 }[key] ?? 0, { ArrowDown: -1, ArrowUp: 1 }[key] ?? 0];
          if (dx === 0 && dy === 0) return false;
          const step = fine ? STEP_M / 10 : STEP_M;
          set({ ...place, x: place.x + dx * step, y: place.y + dy * step });
          return true;
        }} />
      <Grip canvas={sceneCanvas} className="heading" label={`Direction of ${title}: ${text}. Arrow keys turn it.`} begin={begin} drag={turn} end={end} style={{ transform: `translate(${corner.x}px, ${corner.y}px) translate(-50%, -50%)` }}
        step={(key, fine) => {
          const sign = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1 }[key];
          if (sign === undefined) return false;
          turned({ pose: place, middle }, (sign * STEP_RAD) / (fine ? 10 : 1));
          return true;
        }} />
    </>
  );
}

// SPDX-License-Identifier: Apache-2.0
// The way of a robot, and where it was at one moment.
import { worldToScreen, type Bounds } from './camera';
import type { InstanceList } from './gl/program';
import { addHeading, addLine, robotHalf, robotLooks } from './glyphs';
import type { Frame, Path } from './model';
import { rgba, type Palette } from './palette';

// Between two drawn places of the way.
const STEP_PX = 2;

const poseAt = ({ poses }: Path, i: number) => ({ x: poses[3 * i]!, y: poses[3 * i + 1]!, yaw: poses[3 * i + 2]! });

export function boundsOfPath({ poses }: Path): Bounds | undefined {
  if (poses.length === 0) return undefined;
  const bounds = { minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity };
  for (let i = 0; i < poses.length; i += 3) {
    bounds.minX = Math.min(bounds.minX, poses[i]!);
    bounds.maxX = Math.max(bounds.maxX, poses[i]!);
    bounds.minY = Math.min(bounds.minY, poses[i + 1]!);
    bounds.maxY = Math.max(bounds.maxY, poses[i + 1]!);
  }
  return bounds;
}

function addWay(list: InstanceList, frame: Frame, path: Path, begin: number, end: number, colour: number) {
  let last = poseAt(path, begin);
  for (let i = begin + 1; i <= end; ++i) {
    const pose = poseAt(path, i);
    if (i < end && Math.hypot(pose.x - last.x, pose.y - last.y) * frame.camera.scale < STEP_PX) continue;
    addLine(list, frame, last, pose, 2.5, colour);
    last = pose;
  }
}

// What has been driven is strong, what comes is faint.
export function addPath(list: InstanceList, palette: Palette, frame: Frame) {
  const { path } = frame.view;
  const last = (path?.poses.length ?? 0) / 3 - 1;
  if (!path || last < 0) return;
  const { camera, size } = frame;
  const at = Math.min(Math.max(0, path.at), last);
  addWay(list, frame, path, at, last, rgba(palette.colour.stale, 0.7));
  addWay(list, frame, path, 0, at, rgba(palette.colour.robot));
  const pose = poseAt(path, at);
  const place = worldToScreen(camera, size, pose);
  addHeading(list, { x: place.x - size.width / 2, y: size.height / 2 - place.y, yaw: pose.yaw }, robotHalf(camera.scale), robotLooks(palette).fresh);
  const ahead = worldToScreen(camera, size, { x: pose.x + Math.cos(pose.yaw), y: pose.y + Math.sin(pose.yaw) });
  frame.marks.push({ kind: 'path', name: path.name, from: worldToScreen(camera, size, poseAt(path, 0)), to: worldToScreen(camera, size, poseAt(path, last)) });
  frame.marks.push({ kind: 'cursor', name: path.name, from: place, to: ahead });
}

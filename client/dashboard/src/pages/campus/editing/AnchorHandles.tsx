// SPDX-License-Identifier: Apache-2.0
// The anchors of a link point over the map: the chosen one has handles, the others are shown and can be chosen.
import { useEffect, useRef } from 'react';
import type { AnchorPlace } from '../../../graph/draft';
import { draggedTo, gripsOf, HEADING_PX, steppedBy, WEDGE_PX, type Grabbed, type Grips, type Handle } from '../../../graph/handles';
import { covarianceOf, spreadOf, spreadText } from '../../../graph/spread';
import type { Point, Pose } from '../../../scene/camera';
import { Grip } from '../../../ui/Grip';
import { sceneCanvas, useShown } from '../../../scene/shared';
import { pose as poseText } from '../../../ui/format';

const handles: readonly Handle[] = ['middle', 'heading', 'major', 'minor', 'wedge'];

const names: Record<Handle, string> = {
  middle: 'Place of the anchor', heading: 'Direction of the anchor', major: 'Longer axis of the ellipse', minor: 'Shorter axis of the ellipse', wedge: 'Uncertainty of the direction',
};

const degrees = (angle: number) => (angle * 180) / Math.PI;

export interface ShownAnchor {
  map: string;
  title: string;
  place: AnchorPlace;
  // T_world_map.
  frame: Pose;
}

function Ellipse({ grips, isActive }: { grips: Grips; isActive: boolean }) {
  const { middle: { x, y }, majorPx, minorPx, angle, yaw, halfWedge, isEnlarged } = grips;
  const at = (direction: number, length: number) => `${x + length * Math.cos(direction)} ${y - length * Math.sin(direction)}`;
  const large = 2 * halfWedge > Math.PI ? 1 : 0;
  return (
    <g className={isActive ? 'anchor active' : 'anchor'}>
      <path className="wedge" d={`M${x} ${y}L${at(yaw + halfWedge, WEDGE_PX)}A${WEDGE_PX} ${WEDGE_PX} 0 ${large} 1 ${at(yaw - halfWedge, WEDGE_PX)}Z`} />
      <ellipse className={isEnlarged ? 'enlarged' : undefined} cx={x} cy={y} rx={majorPx} ry={minorPx} transform={`rotate(${-degrees(angle)} ${x} ${y})`} />
      <path className="heading" d={`M${x} ${y}L${at(yaw, HEADING_PX)}`} />
    </g>
  );
}

interface Props {
  anchors: readonly ShownAnchor[];
  active: string | undefined;
  choose: (map: string) => void;
  // A drag began; it ended.
  hold: (on: boolean) => void;
  change: (map: string, handle: Handle, to: { pose: Pose; covariance: number[] }, tag: string) => void;
  undo: () => void;
}

let drags = 0;

export function AnchorHandles({ anchors, active, choose, hold, change, undo }: Props) {
  const shown = useShown();
  const grabbed = useRef<{ begin: Grabbed; grips: Grips; frame: Pose; from: Point; tag: string; moved: boolean }>(undefined);
  // The link point may go while it is dragged.
  useEffect(() => () => void (grabbed.current && hold(false)), []);
  if (!shown) return null;
  const { camera, size } = shown;
  const all = anchors.map((anchor) => ({ ...anchor, spread: spreadOf(anchor.place.covariance), grips: gripsOf(anchor.place.pose, spreadOf(anchor.place.covariance), anchor.frame, camera, size) }));
  const own = all.find(({ map }) => map === active);
  const put = (handle: Handle, { pose, spread }: Grabbed, tag: string) => own && change(own.map, handle, { pose, covariance: covarianceOf(spread) }, tag);

  const begin = (handle: Handle, from: Point) => {
    if (!own) return;
    grabbed.current = { begin: { pose: own.place.pose, spread: own.spread }, grips: own.grips, frame: own.frame, from, tag: `${handle} ${++drags}`, moved: false };
    hold(true);
  };
  const drag = (handle: Handle, at: Point) => {
    const it = grabbed.current;
    if (!it) return;
    it.moved = true;
    // The pointer keeps the place of the handle where it took it.
    const target = { x: it.grips[handle === 'wedge' ? 'middle' : handle].x + at.x - it.from.x, y: it.grips[handle === 'wedge' ? 'middle' : handle].y + at.y - it.from.y };
    put(handle, draggedTo(handle, handle === 'wedge' ? at : target, it.begin, it.grips, it.frame, camera.scale), it.tag);
  };
  const end = (cancelled: boolean) => {
    const it = grabbed.current;
    grabbed.current = undefined;
    if (cancelled && it?.moved) undo();
    hold(false);
  };
  const step = (handle: Handle, key: string, fine: boolean) => {
    const next = own && steppedBy(handle, key, fine, { pose: own.place.pose, spread: own.spread }, own.frame);
    if (!next) return false;
    put(handle, next, `${handle} by keys`);
    return true;
  };
  return (
    <>
      <svg className="graph-handles" aria-hidden="true">
        {all.map((anchor) => (
          <Ellipse key={anchor.map} grips={anchor.grips} isActive={anchor === own} />
        ))}
      </svg>
      {all.filter((anchor) => anchor !== own).map(({ map, title, grips: { middle } }) => (
        <button key={map} type="button" className="grip other" aria-label={`Choose the anchor in ${title}`} title={`Choose the anchor in ${title}`}
          style={{ transform: `translate(${middle.x}px, ${middle.y}px) translate(-50%, -50%)` }} onClick={() => choose(map)} />
      ))}
      {own && handles.map((handle) => {
        const at = handle === 'wedge' ? own.grips.wedge[0] : own.grips[handle];
        const value = handle === 'middle' || handle === 'heading' ? poseText(own.place.pose) : `σ ${spreadText(own.spread)}`;
        return (
          <Grip key={handle} canvas={sceneCanvas} className={handle} label={`${names[handle]} in ${own.title}: ${value}. Arrow keys change it.`}
            style={{ transform: `translate(${at.x}px, ${at.y}px) translate(-50%, -50%)` }} begin={(from) => begin(handle, from)} drag={(to) => drag(handle, to)} end={end}
            step={(key, fine) => step(handle, key, fine)} />
        );
      })}
    </>
  );
}

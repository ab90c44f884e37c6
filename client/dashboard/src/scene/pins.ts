// SPDX-License-Identifier: Apache-2.0
// Places that a page marks.
import { worldToScreen } from './camera';
import { addGlyph, shape } from './gl/glyphLayer';
import type { InstanceList } from './gl/program';
import type { Frame } from './model';
import { rgba, type Palette } from './palette';

const HALF_PX = 6;

export function addPins(list: InstanceList, palette: Palette, frame: Frame) {
  const { size, camera, view } = frame;
  for (const { name, at, active } of view.pins ?? []) {
    const place = worldToScreen(camera, size, at);
    const [x, y] = [place.x - size.width / 2, size.height / 2 - place.y];
    const colour = active ? palette.colour.select : palette.colour.robot;
    addGlyph(list, { x, y, halfX: HALF_PX + 2, halfY: HALF_PX + 2, angle: 0, shape: shape.disc, stroke: 0, dash: 0, line: 0, fill: rgba(palette.colour.halo) });
    addGlyph(list, { x, y, halfX: HALF_PX, halfY: HALF_PX, angle: 0, shape: shape.disc, stroke: 2, dash: 0, line: rgba(colour), fill: rgba(colour, active ? 0 : 0.25) });
    addGlyph(list, { x, y, halfX: 1.5, halfY: 1.5, angle: 0, shape: shape.disc, stroke: 0, dash: 0, line: 0, fill: rgba(colour) });
    frame.marks.push({ kind: 'pin', name, from: place, to: place });
  }
}

// SPDX-License-Identifier: Apache-2.0
// Where robots come from: a line behind each that fades. That of the selected robot is longer.
import { affineOf, type Affine } from './affine';
import { worldToScreen, type Point, type Pose } from './camera';
import { addLine } from './glyphs';
import type { InstanceList } from './gl/program';
import type { Frame } from './model';
import { rgba, type Palette } from './palette';

const SHOWN_S = 20;
const SELECTED_S = 300;
// Between two drawn places.
const STEP_PX = 3;
const SHADES = 16;

export class TrailPainter {
  private readonly frames = new Map<string, Affine | undefined>();
  private readonly shades: number[];
  private readonly isOwn: boolean;

  // `places`: where the maps are drawn.
  constructor(private readonly list: InstanceList, private readonly frame: Frame, private readonly places: ReadonlyMap<string, Pose>, { colour }: Palette) {
    this.shades = Array.from({ length: SHADES + 1 }, (_, i) => rgba(colour.robot, (0.7 * i) / SHADES));
    this.isOwn = frame.view.map !== undefined;
  }

  // Back from `at`, where the robot is drawn.
  paint(robot: string, at: Point) {
    const { frame, list } = this;
    const isSelected = frame.view.selected === robot;
    const shown = isSelected ? SELECTED_S : SHOWN_S;
    let [last, end, isJoined] = [at, at, true];
    frame.site.trails.of(robot)?.walk((map, x, y, receiveTime, comesFromBefore) => {
      const age = frame.site.ageOf(receiveTime, frame.wall);
      const affine = this.frameOf(map);
      if (age > shown || !affine) return false;
      const [wx, wy] = [affine.a * x + affine.c * y + affine.e, affine.b * x + affine.d * y + affine.f];
      const isNear = Math.hypot(wx - last.x, wy - last.y) * frame.camera.scale < STEP_PX;
      if (isJoined && isNear && comesFromBefore) return true;
      const place = { x: wx, y: wy };
      if (isJoined) addLine(list, frame, last, place, isSelected ? 3 : 2, this.shades[Math.ceil(SHADES * (1 - age / shown))]!);
      end = last = place;
      isJoined = comesFromBefore;
      return true;
    });
    if (isSelected && end !== at) frame.marks.push({ kind: 'trail', name: robot, from: this.onScreen(at), to: this.onScreen(end) });
  }

  private frameOf(map: string): Affine | undefined {
    if (this.isOwn && map !== this.frame.view.map) return undefined;
    let affine = this.frames.get(map);
    if (affine === undefined && !this.frames.has(map)) {
      const pose = this.isOwn ? { x: 0, y: 0, yaw: 0 } : this.places.get(map);
      this.frames.set(map, (affine = pose && affineOf(pose)));
    }
    return affine;
  }

  private onScreen(at: Point): Point {
    return worldToScreen(this.frame.camera, this.frame.size, at);
  }
}

// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import type { RobotState } from '../gen/enfilade/v1/watch_service_pb';

// A robot as lists and inspectors show it: a copy out of the table.
export interface LiveRobot {
  name: string;
  map: string;
  session: string;
  level: number;
  poseMap: { x: number; y: number; yaw: number };
  // Absent if no link points join its map to the root.
  poseWorld?: { x: number; y: number; yaw: number };
  // [xx, xy, yy] m^2 and the variance of yaw, rad^2; of poseWorld, else of poseMap.
  covariance: [number, number, number, number];
  // Milliseconds since 1970, by the robot's and by the server's clock.
  reportTime: number;
  receiveTime: number;
}

const POSE = 3;
const COVARIANCE = 4;

function grown<T extends Float64Array | Float32Array | Int32Array | Uint8Array>(old: T, length: number): T {
  const next = new (old.constructor as new (n: number) => T)(length);
  next.set(old);
  return next;
}

// The poses of a site's robots in typed arrays, so that a renderer reads them each frame without making objects. A robot
// that is removed gives its row to the last one.
export class RobotTable {
  count = 0;
  names: string[] = [];
  maps: string[] = [];
  sessions: string[] = [];
  // x, y, yaw in the world frame; only valid where placed is 1.
  world = new Float64Array(POSE * 64);
  map = new Float64Array(POSE * 64);
  covariance = new Float32Array(COVARIANCE * 64);
  placed = new Uint8Array(64);
  level = new Int32Array(64);
  reportTime = new Float64Array(64);
  receiveTime = new Float64Array(64);
  private readonly rows = new Map<string, number>();

  rowOf(name: string): number | undefined {
    return this.rows.get(name);
  }

  clear() {
    this.count = 0;
    this.rows.clear();
    this.names = [];
    this.maps = [];
    this.sessions = [];
  }

  set(state: RobotState) {
    let row = this.rows.get(state.robot);
    if (row === undefined) {
      row = this.count++;
      if (row >= this.placed.length) this.grow();
      this.rows.set(state.robot, row);
      this.names[row] = state.robot;
    }
    this.maps[row] = state.map;
    this.sessions[row] = state.session;
    this.level[row] = state.level;
    const world = state.poseWorldRobot;
    this.placed[row] = world ? 1 : 0;
    this.world.set([world?.x ?? 0, world?.y ?? 0, world?.yaw ?? 0], POSE * row);
    const map = state.poseMapRobot;
    this.map.set([map?.x ?? 0, map?.y ?? 0, map?.yaw ?? 0], POSE * row);
    for (let i = 0; i < COVARIANCE; ++i) this.covariance[COVARIANCE * row + i] = state.covariance[i] ?? 0;
    this.reportTime[row] = state.reportTime ? timestampMs(state.reportTime) : 0;
    this.receiveTime[row] = state.receiveTime ? timestampMs(state.receiveTime) : 0;
  }

  remove(name: string) {
    const row = this.rows.get(name);
    if (row === undefined) return;
    const last = --this.count;
    this.rows.delete(name);
    if (row !== last) this.move(last, row);
    this.names.length = this.maps.length = this.sessions.length = this.count;
  }

  get(name: string): LiveRobot | undefined {
    const row = this.rows.get(name);
    return row === undefined ? undefined : this.at(row);
  }

  at(row: number): LiveRobot {
    const pose = (from: Float64Array) => ({ x: from[POSE * row]!, y: from[POSE * row + 1]!, yaw: from[POSE * row + 2]! });
    const c = this.covariance.subarray(COVARIANCE * row, COVARIANCE * row + COVARIANCE);
    return {
      name: this.names[row]!, map: this.maps[row]!, session: this.sessions[row]!, level: this.level[row]!, poseMap: pose(this.map),
      ...(this.placed[row] && { poseWorld: pose(this.world) }), covariance: [c[0]!, c[1]!, c[2]!, c[3]!],
      reportTime: this.reportTime[row]!, receiveTime: this.receiveTime[row]!,
    };
  }

  all(): LiveRobot[] {
    return Array.from({ length: this.count }, (_, row) => this.at(row));
  }

  private move(from: number, to: number) {
    const name = this.names[from]!;
    this.rows.set(name, to);
    this.names[to] = name;
    this.maps[to] = this.maps[from]!;
    this.sessions[to] = this.sessions[from]!;
    this.world.copyWithin(POSE * to, POSE * from, POSE * (from + 1));
    this.map.copyWithin(POSE * to, POSE * from, POSE * (from + 1));
    this.covariance.copyWithin(COVARIANCE * to, COVARIANCE * from, COVARIANCE * (from + 1));
    for (const column of [this.placed, this.level, this.reportTime, this.receiveTime]) column[to] = column[from]!;
  }

  private grow() {
    const rows = 2 * this.placed.length;
    this.world = grown(this.world, POSE * rows);
    this.map = grown(this.map, POSE * rows);
    this.covariance = grown(this.covariance, COVARIANCE * rows);
    this.placed = grown(this.placed, rows);
    this.level = grown(this.level, rows);
    this.reportTime = grown(this.reportTime, rows);
    this.receiveTime = grown(this.receiveTime, rows);
  }
}

// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import type { RobotState } from '../gen/enfilade/v1/watch_service_pb';

// Places that a trail keeps: 40 m or more of way.
const PLACES = 128;
// Between two of them.
const STEP_M = 0.3;
// Two reports belong to one way if no more time lies between them, and no more way than a robot can have driven.
const GAP_S = 10;
const FASTEST_M_S = 5;
const SLACK_M = 1;

interface Report {
  map: string;
  x: number;
  y: number;
  // Absent if the map has no place in the world.
  world: { x: number; y: number } | undefined;
  // By the robot's clock, ms.
  time: number;
}

function joins(a: Report, b: Report): boolean {
  const seconds = (b.time - a.time) / 1000;
  if (!(seconds >= 0 && seconds <= GAP_S)) return false;
  const [from, to] = a.map === b.map ? [a, b] : [a.world, b.world];
  return from !== undefined && to !== undefined && Math.hypot(to.x - from.x, to.y - from.y) <= SLACK_M + FASTEST_M_S * seconds;
}

// The last places of one robot, in the frames of the maps that it was in: they move with the maps.
export class Trail {
  count = 0;
  private newest = -1;
  private last: Report | undefined;
  private readonly maps: string[] = new Array<string>(PLACES).fill('');
  private readonly xy = new Float32Array(2 * PLACES);
  private readonly receiveTimes = new Float64Array(PLACES);
  // Whether the way comes from the place before.
  private readonly joined = new Uint8Array(PLACES);

  add(report: Report, receiveTime: number) {
    const { last } = this;
    this.last = report;
    const isJoined = last !== undefined && joins(last, report);
    if (isJoined && this.maps[this.newest] === report.map) {
      const i = this.newest;
      if (Math.hypot(report.x - this.xy[2 * i]!, report.y - this.xy[2 * i + 1]!) < STEP_M) return;
    }
    this.newest = (this.newest + 1) % PLACES;
    this.count = Math.min(this.count + 1, PLACES);
    this.maps[this.newest] = report.map;
    this.xy[2 * this.newest] = report.x;
    this.xy[2 * this.newest + 1] = report.y;
    this.receiveTimes[this.newest] = receiveTime;
    this.joined[this.newest] = isJoined ? 1 : 0;
  }

  // From the newest place backwards, until `take` returns false. `isJoined`: the way goes on to the next one.
  walk(take: (map: string, x: number, y: number, receiveTime: number, isJoined: boolean) => boolean) {
    for (let n = 0; n < this.count; ++n) {
      const i = (this.newest - n + PLACES) % PLACES;
      if (!take(this.maps[i]!, this.xy[2 * i]!, this.xy[2 * i + 1]!, this.receiveTimes[i]!, this.joined[i] === 1)) return;
    }
  }
}

// Where robots have been, as far as this page has seen it.
export class Trails {
  private readonly trails = new Map<string, Trail>();

  add(state: RobotState) {
    let trail = this.trails.get(state.robot);
    if (!trail) this.trails.set(state.robot, (trail = new Trail()));
    const { x = 0, y = 0 } = state.poseMapRobot ?? {};
    const time = state.reportTime ? timestampMs(state.reportTime) : 0;
    trail.add({ map: state.map, x, y, world: state.poseWorldRobot, time }, state.receiveTime ? timestampMs(state.receiveTime) : 0);
  }

  of(robot: string): Trail | undefined {
    return this.trails.get(robot);
  }

  remove(robot: string) {
    this.trails.delete(robot);
  }

  clear() {
    this.trails.clear();
  }
}

// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import type { GraphLinkPoint, GraphMap } from '../gen/enfilade/v1/graph_pb';
import { Session_State } from '../gen/enfilade/v1/session_pb';
import type { GraphDelta, SessionState, SiteHealth, WatchSiteResponse } from '../gen/enfilade/v1/watch_service_pb';
import { Signal } from '../signal';
import { Rate } from './rate';
import { RobotTable } from './robots';
import { Trails } from './trails';

export interface Raster {
  // sites/{site}/maps/{map}/revisions/{revision}
  revision: string;
  createTime: number;
}

// What the stream is doing. `since`, `retryAt`: milliseconds since 1970.
export type StreamState =
  | { kind: 'connecting' }
  | { kind: 'live' }
  | { kind: 'lost'; since: number; retryAt: number; reason: string }
  | { kind: 'refused'; error: unknown };

// All that is known of a site, fed by one stream. A renderer reads it each frame; React subscribes and is told at most
// four times a second. Whatever is keyed is keyed by its whole resource name.
export class LiveSite {
  readonly robots = new RobotTable();
  readonly trails = new Trails();
  readonly maps = new Map<string, GraphMap>();
  readonly linkPoints = new Map<string, GraphLinkPoint>();
  readonly rasters = new Map<string, Raster>();
  readonly sessions = new Map<string, SessionState>();
  rootMap = '';
  graphVersion = 0n;
  solutionVersion = 0n;
  health: SiteHealth | undefined;
  serverVersion = '';
  // False until all that was there at the start has come.
  complete = false;
  state: StreamState = { kind: 'connecting' };
  // This clock less the server's, ms: ages are told by the server's clock, whatever this one shows.
  clockOffset = 0;
  // Grow with each change of what they count, so that a renderer sees what it has to do again.
  graphRevision = 0;
  rasterRevision = 0;
  poseRevision = 0;

  private readonly rates = new Map<string, Rate>();
  private version = 0;
  private readonly changed = new Signal();
  private timer: ReturnType<typeof setTimeout> | undefined;
  private lastTold = 0;

  constructor(readonly id: string) {}

  readonly subscribe = this.changed.subscribe;

  readonly snapshot = () => this.version;

  setState(state: StreamState) {
    this.state = state;
    this.tellNow();
  }

  apply(message: WatchSiteResponse, now: number) {
    if (message.start?.reset) this.reset();
    if (message.start) this.serverVersion = message.start.serverVersion;
    if (message.sendTime) this.clockOffset = now - timestampMs(message.sendTime);
    if (message.graph) this.applyGraph(message.graph);
    for (const raster of message.rasters) {
      this.rasters.set(raster.map, { revision: raster.revision, createTime: raster.createTime ? timestampMs(raster.createTime) : 0 });
    }
    if (message.rasters.length > 0) ++this.rasterRevision;
    for (const robot of message.removedRobots) {
      this.robots.remove(robot);
      this.trails.remove(robot);
    }
    for (const robot of message.robots) {
      this.robots.set(robot);
      this.trails.add(robot);
    }
    if (message.robots.length + message.removedRobots.length > 0) ++this.poseRevision;
    for (const session of message.removedSessions) {
      this.sessions.delete(session);
      this.rates.delete(session);
    }
    for (const session of message.sessions) this.setSession(session, now);
    if (message.health) this.health = message.health;
    if (!message.more) this.complete = true;
    this.tell();
  }

  // Seconds since the server received it.
  ageOf(receiveTime: number, now: number): number {
    return Math.max(0, (now - this.clockOffset - receiveTime) / 1000);
  }

  // Records that a session has stored each second, lately.
  recordRate(session: string): number {
    return this.rates.get(session)?.perSecond(Date.now()) ?? 0;
  }

  levels(): number[] {
    const found = new Set<number>();
    for (const map of this.maps.values()) found.add(map.level);
    return [...found].sort((a, b) => a - b);
  }

  private setSession(session: SessionState, now: number) {
    this.sessions.set(session.session, session);
    if (session.state !== Session_State.RECORDING) {
      this.rates.delete(session.session);
      return;
    }
    const rate = this.rates.get(session.session) ?? new Rate();
    this.rates.set(session.session, rate);
    rate.add(now, Number(session.acknowledgedSequence));
  }

  private applyGraph(delta: GraphDelta) {
    for (const map of delta.removedMaps) {
      this.maps.delete(map);
      this.rasters.delete(map);
    }
    for (const linkPoint of delta.removedLinkPoints) this.linkPoints.delete(linkPoint);
    for (const map of delta.maps) this.maps.set(map.map, map);
    for (const linkPoint of delta.linkPoints) this.linkPoints.set(linkPoint.linkPoint, linkPoint);
    this.rootMap = delta.rootMap;
    this.graphVersion = delta.graphVersion;
    this.solutionVersion = delta.solutionVersion;
    ++this.graphRevision;
  }

  private reset() {
    this.robots.clear();
    this.trails.clear();
    this.maps.clear();
    this.linkPoints.clear();
    this.rasters.clear();
    this.sessions.clear();
    this.rates.clear();
    this.complete = false;
    ++this.graphRevision;
    ++this.rasterRevision;
    ++this.poseRevision;
  }

  private tell() {
    if (this.timer !== undefined) return;
    const wait = Math.max(0, 250 - (Date.now() - this.lastTold));
    this.timer = setTimeout(() => this.tellNow(), wait);
  }

  private tellNow() {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.lastTold = Date.now();
    ++this.version;
    this.changed.tell();
  }
}

// SPDX-License-Identifier: Apache-2.0
import './session.css';
import { useEffect, useMemo, useRef, useState } from 'react';
import { currentPlace, setQuery } from '../../app/router';
import { Session_State, type Session } from '../../gen/enfilade/v1/session_pb';
import { useLive } from '../../live/context';
import type { View } from '../../scene/model';
import { SceneView } from '../../scene/SceneView';
import { clock, pose as poseText } from '../../ui/format';
import { Player } from '../../ui/Player';
import { Failed, Loading } from '../../ui/States';
import { Readout, type ReadoutHandle } from '../campus/Readout';
import { indexAt, useTrajectory, type Trajectory } from './trajectory';

const FRAME_MS = 50;
// Without animation it goes on by steps.
const STEP_MS = 1000;
const speeds = [1, 5, 20];

const seconds = (value: number) => Math.round(10 * value) / 10;

// The moment of the address, in seconds since the begin; it follows when the moment has stood for a while.
function useMoment(duration: number): [number, (value: number) => void] {
  const [at, setAt] = useState(() => {
    const text = currentPlace().query.get('t');
    return text === null || !(Number(text) >= 0) ? 0 : Number(text);
  });
  const shown = seconds(Math.min(at, duration));
  useEffect(() => {
    const timer = setTimeout(() => setQuery({ t: shown > 0 ? String(shown) : undefined }), 300);
    return () => clearTimeout(timer);
  }, [shown]);
  return [shown, setAt];
}

function useReplay(at: number, duration: number, speed: number, setAt: (value: number) => void) {
  const [playing, setPlaying] = useState(false);
  const next = useRef((_: number) => {});
  next.current = (ms) => {
    setAt(Math.min(duration, at + (speed * ms) / 1000));
    if (at >= duration) setPlaying(false);
  };
  useEffect(() => {
    if (!playing) return;
    const period = window.matchMedia('(prefers-reduced-motion: reduce)').matches ? STEP_MS : FRAME_MS;
    let last = performance.now();
    const timer = setInterval(() => {
      const now = performance.now();
      next.current(now - last);
      last = now;
    }, period);
    return () => clearInterval(timer);
  }, [playing]);
  const set = (on: boolean) => {
    if (on && at >= duration) setAt(0);
    setPlaying(on);
  };
  return { playing, setPlaying: set };
}

function Replay({ session, map, trajectory: { times, poses } }: { session: string; map: string; trajectory: Trajectory }) {
  const readout = useRef<ReadoutHandle>(null);
  const [speed, setSpeed] = useState(5);
  const begin = times[0]!;
  const duration = seconds((times[times.length - 1]! - begin) / 1000);
  const [at, setAt] = useMoment(duration);
  const { playing, setPlaying } = useReplay(at, duration, speed, setAt);
  // Half a step more: the slider's moments are rounded.
  const index = indexAt(times, begin + 1000 * at + 50);
  const view = useMemo<View>(() => ({ map, path: { name: session, poses, at: index } }), [map, session, poses, index]);
  const [x, y, yaw] = poses.subarray(3 * index, 3 * index + 3);
  const text = `${at.toFixed(1)} s · ${clock(times[index]!)} · ${poseText({ x: x!, y: y!, yaw: yaw! })}`;
  return (
    <>
      <SceneView view={view} events={{ hover: (...over) => readout.current?.hover(...over) }}>
        <Readout ref={readout} said="" />
      </SceneView>
      <Player label="Time in the session" text={text} value={at} max={duration} step={0.1} onChange={setAt} playing={playing} setPlaying={setPlaying}>
        <select className="select" aria-label="Speed" value={speed} onChange={(event) => setSpeed(Number(event.target.value))}>
          {speeds.map((times) => (
            <option key={times} value={times}>
              {times} ×
            </option>
          ))}
        </select>
      </Player>
    </>
  );
}

// Where the robot drove in this session, on its map, from moment to moment.
export function TrajectoryView({ session }: { session: Session }) {
  const live = useLive();
  const { state, map } = live.sessions.get(session.name) ?? session;
  const grows = state === Session_State.RECORDING || state === Session_State.FINISHED;
  const { data, error, refetch } = useTrajectory(session.name, grows);
  const why =
    map === '' ? 'It is not decided yet in which map the robot drove.'
    : !live.maps.has(map) ? 'The map of this session is gone.'
    : data?.times.length === 0 ? 'No scan of this session has been mapped yet.'
    : undefined;
  return (
    <section className="card trajectory" aria-label="Trajectory">
      {error && !data ? <Failed error={error} retry={() => void refetch()} /> : why !== undefined ? <p className="sub none">{why}</p> : !data ? <Loading /> : <Replay session={session.name} map={map} trajectory={data} />}
    </section>
  );
}

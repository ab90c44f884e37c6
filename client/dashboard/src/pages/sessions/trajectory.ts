// SPDX-License-Identifier: Apache-2.0
import { timestampMs } from '@bufbuild/protobuf/wkt';
import { useQuery } from '@tanstack/react-query';
import { sessions } from '../../api/clients';
import type { TrajectoryPose } from '../../gen/enfilade/v1/session_service_pb';

// Where a session's robot was, in the order of time.
export interface Trajectory {
  // Milliseconds since 1970, by the robot's clock.
  times: Float64Array;
  // x, y, yaw of each in the session's map.
  poses: Float64Array;
}

export function trajectoryOf(found: TrajectoryPose[]): Trajectory {
  const times = new Float64Array(found.length);
  const poses = new Float64Array(3 * found.length);
  found.forEach(({ time, poseMapRobot }, i) => {
    times[i] = time ? timestampMs(time) : 0;
    poses.set([poseMapRobot?.x ?? 0, poseMapRobot?.y ?? 0, poseMapRobot?.yaw ?? 0], 3 * i);
  });
  return { times, poses };
}

// The last moment that is not after `time`; the first, if all are.
export function indexAt(times: Float64Array, time: number): number {
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle]! <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

const AGAIN_MS = 5000;

// Read anew while the session is recorded or mapped.
export function useTrajectory(session: string, grows: boolean) {
  return useQuery<Trajectory>({
    queryKey: ['trajectory', session, grows],
    placeholderData: (earlier) => earlier,
    refetchInterval: grows ? AGAIN_MS : false,
    queryFn: async ({ signal }) => {
      const found: TrajectoryPose[] = [];
      for await (const part of sessions.exportTrajectory({ name: session }, { signal })) found.push(...part.poses);
      return trajectoryOf(found);
    },
  });
}

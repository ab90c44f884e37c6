// SPDX-License-Identifier: Apache-2.0
import { create } from '@bufbuild/protobuf';
import { timestampFromMs } from '@bufbuild/protobuf/wkt';
import { expect, test } from 'vitest';
import { TrajectoryPoseSchema } from '../../gen/enfilade/v1/session_service_pb';
import { indexAt, trajectoryOf } from './trajectory';

test('keeps times to the millisecond, and poses side by side', () => {
  const pose = (ms: number, x: number) => create(TrajectoryPoseSchema, { time: timestampFromMs(ms), poseMapRobot: { x, y: -x, yaw: 0.5 } });
  const { times, poses } = trajectoryOf([pose(1_700_000_000_123, 1), pose(1_700_000_000_623, 2)]);
  expect([...times]).toEqual([1_700_000_000_123, 1_700_000_000_623]);
  expect([...poses]).toEqual([1, -1, 0.5, 2, -2, 0.5]);
});

test('finds the last moment that is not after a time', () => {
  const times = Float64Array.of(10, 20, 30);
  expect([5, 10, 19, 20, 29, 30, 99].map((time) => indexAt(times, time))).toEqual([0, 0, 0, 1, 1, 2, 2]);
  expect(indexAt(Float64Array.of(7), 0)).toBe(0);
});

-- SPDX-License-Identifier: Apache-2.0
-- When the server received each robot's last pose.
BEGIN;

-- By the server's clock, in nanoseconds since 1970. A time ahead of it does not count: what was dated far ahead before
-- gives way to the next report.
ALTER TABLE enfilade.robot_poses ADD COLUMN received_ns bigint NOT NULL
  DEFAULT (extract(epoch FROM clock_timestamp()) * 1000000000)::bigint;

COMMIT;

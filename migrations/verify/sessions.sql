-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, session_id, robot_id, map_id, state, acknowledged_sequence, highest_sequence, laser_scans, odometry,
  images, point_clouds, withheld, payload_bytes, first_time_ns, last_time_ns, error, records_deleted, request_id,
  create_time, finish_time, delete_time, purged
FROM enfilade.sessions WHERE false;
SELECT site_id, session_id, sequence, time_ns, kind, payload FROM enfilade.session_records WHERE false;
SELECT site_id, session_id, sequence, sha256 FROM enfilade.session_record_blobs WHERE false;

ROLLBACK;

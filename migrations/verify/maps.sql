-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, map_id, display_name, level, environment, slam_profile, outline, state, current_revision, request_id,
  etag, create_time, update_time
FROM enfilade.maps WHERE false;
SELECT 1 / count(*) FROM pg_indexes WHERE schemaname = 'enfilade' AND indexname = 'maps_outline_idx';

ROLLBACK;

-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, display_name, raw_retention_s, request_id, etag, create_time, update_time FROM enfilade.sites WHERE false;
SELECT site_id, robot_id, display_name, request_id, etag, create_time, update_time FROM enfilade.robots WHERE false;

ROLLBACK;

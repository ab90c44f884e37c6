-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT request_sha256 FROM enfilade.sites WHERE false;
SELECT request_sha256 FROM enfilade.robots WHERE false;
SELECT request_sha256 FROM enfilade.maps WHERE false;
SELECT request_sha256 FROM enfilade.sessions WHERE false;
SELECT request_sha256 FROM enfilade.link_points WHERE false;

ROLLBACK;

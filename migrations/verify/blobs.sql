-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, sha256, size, put_time, data FROM enfilade.blobs WHERE false;

ROLLBACK;

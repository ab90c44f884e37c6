-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.session_record_blobs;
DROP TABLE enfilade.session_records;
DROP TABLE enfilade.sessions;

COMMIT;

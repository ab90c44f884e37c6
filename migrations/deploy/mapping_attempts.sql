-- SPDX-License-Identifier: Apache-2.0
-- How often a session was taken for mapping without being released.
BEGIN;

ALTER TABLE enfilade.session_leases ADD COLUMN attempts bigint NOT NULL DEFAULT 0 CHECK (attempts >= 0);

COMMIT;

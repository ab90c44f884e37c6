-- SPDX-License-Identifier: Apache-2.0
BEGIN;

ALTER TABLE enfilade.rearrangements DROP COLUMN undo_purged, DROP COLUMN undo_expired;

COMMIT;

-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT undo_expired, undo_purged FROM enfilade.rearrangements WHERE false;

ROLLBACK;

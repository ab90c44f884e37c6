-- SPDX-License-Identifier: Apache-2.0
-- What undoing a rearrangement needs is deleted some time after it was made.
BEGIN;

ALTER TABLE enfilade.rearrangements
  ADD COLUMN undo_expired boolean NOT NULL DEFAULT false,  -- it is deleted, or being deleted: undoing is refused
  ADD COLUMN undo_purged boolean NOT NULL DEFAULT false,   -- all of it is deleted
  ADD CONSTRAINT rearrangements_purged_check CHECK (undo_expired OR NOT undo_purged);
CREATE INDEX rearrangements_to_purge_idx ON enfilade.rearrangements (create_time) WHERE NOT undo_purged;

COMMIT;

-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'several_cuts';

-- Of a session's cuts only one can be kept: without the others the rearrangement cannot be undone.
WITH more AS (
  DELETE FROM enfilade.rearrangement_parts p WHERE EXISTS (SELECT FROM enfilade.rearrangement_parts o
    WHERE o.site_id = p.site_id AND o.rearrangement_id = p.rearrangement_id AND o.kind = p.kind
    AND o.subject = p.subject AND o.ordinal < p.ordinal)
  RETURNING site_id, rearrangement_id)
UPDATE enfilade.rearrangements r SET undo_expired = true FROM more
  WHERE r.site_id = more.site_id AND r.rearrangement_id = more.rearrangement_id;
ALTER TABLE enfilade.rearrangement_parts
  DROP CONSTRAINT rearrangement_parts_pkey,
  ADD PRIMARY KEY (site_id, rearrangement_id, kind, subject);
COMMIT;

-- SPDX-License-Identifier: Apache-2.0
-- A rearrangement may cut a session at several records.
BEGIN;

ALTER TABLE enfilade.rearrangement_parts
  DROP CONSTRAINT rearrangement_parts_pkey,
  ADD PRIMARY KEY (site_id, rearrangement_id, kind, ordinal);

INSERT INTO enfilade.schema_compatibility VALUES ('several_cuts', 'pins');
COMMIT;

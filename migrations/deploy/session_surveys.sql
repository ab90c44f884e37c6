-- SPDX-License-Identifier: Apache-2.0
-- Which sessions a survey of their site has seen.
BEGIN;

-- Sites from before surveys stay as they are until a robot drives there again.
ALTER TABLE enfilade.sessions ADD COLUMN surveyed boolean NOT NULL DEFAULT true;
ALTER TABLE enfilade.sessions ALTER COLUMN surveyed SET DEFAULT false;
CREATE INDEX sessions_to_survey_idx ON enfilade.sessions (site_id, session_id)
  WHERE map_id IS NOT NULL AND state = 3 AND NOT surveyed;

COMMIT;

-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'prior_maps';
-- Their blobs may be unused from now on.
INSERT INTO enfilade.loose_blobs (site_id, sha256, since)
  SELECT DISTINCT site_id, sha256, '-infinity'::timestamptz FROM enfilade.prior_map_files;
DROP TABLE enfilade.prior_map_files;
DROP TABLE enfilade.prior_maps;
COMMIT;

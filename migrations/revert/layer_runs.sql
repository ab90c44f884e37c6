-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'layer_runs';
ALTER TABLE enfilade.map_layers ALTER version SET DEFAULT nextval('enfilade.etags');
-- A change must again raise the greatest version of its map's layers.
SELECT setval('enfilade.etags', greatest(nextval('enfilade.etags'), max(version))) FROM enfilade.map_layer_stacks;
DROP TABLE enfilade.map_layer_run_tiles;
DROP TABLE enfilade.map_layer_runs;
DROP TABLE enfilade.map_layer_stacks;
COMMIT;

-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.map_layer_tiles;
DROP TABLE enfilade.map_layers;

COMMIT;

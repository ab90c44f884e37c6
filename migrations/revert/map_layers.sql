BEGIN;

DROP TABLE enfilade.map_layer_tiles;
DROP TABLE enfilade.map_layers;

COMMIT;

-- SPDX-License-Identifier: Apache-2.0
SELECT version FROM enfilade.map_layer_stacks WHERE false;
SELECT first_position, last_position, resolution, reset_header, content_header FROM enfilade.map_layer_runs WHERE false;
SELECT part, sha256 FROM enfilade.map_layer_run_tiles WHERE false;

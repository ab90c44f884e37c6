-- SPDX-License-Identifier: Apache-2.0
-- Floor plans and emergency plans of a site's levels, and where they lie in the world.
BEGIN;

CREATE TABLE enfilade.prior_maps (
  site_id      text COLLATE "C" NOT NULL REFERENCES enfilade.sites,
  prior_map_id enfilade.resource_id NOT NULL,
  display_name enfilade.display_name NOT NULL,
  level        integer NOT NULL,
  state        smallint NOT NULL CHECK (state BETWEEN 1 AND 5),  -- new, proposed, active, diverged, suspended
  reason       text NOT NULL,
  file_name    text NOT NULL,
  warnings     text[] NOT NULL,
  walls        integer NOT NULL,
  corners      integer NOT NULL,
  doors        integer NOT NULL,
  rooms        integer NOT NULL,
  shafts       integer NOT NULL,
  metres_per_unit double precision,  -- NULL: unknown
  -- The last alignment that was accepted; all NULL: none was.
  affine        double precision[] CHECK (cardinality(affine) = 6),  -- from the sheet to m of the world, row by row
  model         smallint CHECK (model BETWEEN 1 AND 4),  -- rigid, similarity, anisotropic, affine
  explained     double precision,
  contradicted  double precision,
  rival_ratio   double precision,
  aligned_maps  text[],
  graph_version bigint,
  pair_maps     text[],              -- of each control pair; '': in the world frame
  pair_points   double precision[],  -- x, y on the sheet, x, y in the map, pair after pair
  align_time    timestamptz,
  etag          bigint NOT NULL DEFAULT nextval('enfilade.etags'),
  create_time   timestamptz NOT NULL DEFAULT now(),
  update_time   timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, prior_map_id),
  UNIQUE (site_id, display_name),
  CONSTRAINT prior_maps_alignment_check CHECK (num_nulls(affine, model, explained, contradicted, rival_ratio, aligned_maps,
    graph_version, pair_maps, pair_points, align_time) IN (0, 10)),
  CONSTRAINT prior_maps_pairs_check CHECK (cardinality(pair_points) = 4 * cardinality(pair_maps))
);
CREATE TRIGGER prior_maps_deleted_site BEFORE INSERT ON enfilade.prior_maps
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_in_deleted_site();
CREATE TRIGGER prior_maps_audit AFTER INSERT OR UPDATE OR DELETE ON enfilade.prior_maps
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('priorMaps/%s', 'prior_map_id');

-- The imported file, what was found in it, and what was made of it.
CREATE TABLE enfilade.prior_map_files (
  site_id      text COLLATE "C" NOT NULL,
  prior_map_id enfilade.resource_id NOT NULL,
  product      smallint NOT NULL CHECK (product BETWEEN 1 AND 5),  -- sheet, plan, corrected, planning, picture
  name         text COLLATE "C" NOT NULL,
  size_bytes   bigint NOT NULL,
  sha256       enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, prior_map_id, product, name),
  FOREIGN KEY (site_id, prior_map_id) REFERENCES enfilade.prior_maps ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX prior_map_files_blob_idx ON enfilade.prior_map_files (site_id, sha256);
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.prior_map_files FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.prior_map_files FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();

INSERT INTO enfilade.schema_compatibility VALUES ('prior_maps', 'prior_maps');
COMMIT;

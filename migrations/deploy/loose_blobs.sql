-- SPDX-License-Identifier: Apache-2.0
-- Lists the blobs that may be unused, so that looking for them does not cost more the more are in use.
BEGIN;

-- Every blob without references is here, perhaps more than once; who looks at it takes it out. It may be in use, or
-- gone.
CREATE TABLE enfilade.loose_blobs (
  site_id text COLLATE "C" NOT NULL,
  sha256  enfilade.sha256_digest NOT NULL,
  since   timestamptz NOT NULL,  -- not looked at before the grace period after it
  entry   uuid NOT NULL DEFAULT gen_random_uuid(),
  PRIMARY KEY (site_id, since, sha256, entry)
);

-- Sites whose blobs from before there was a list are still to be listed, in the order of their digests.
CREATE TABLE enfilade.blob_listings (
  site_id   text COLLATE "C" PRIMARY KEY,
  listed_to bytea NOT NULL  -- the last one listed; empty: none
);
INSERT INTO enfilade.blob_listings SELECT site_id, '' FROM enfilade.sites;

-- Entries are only added, and rows of others are not locked: writers never wait for each other.
CREATE FUNCTION enfilade.list_new_blob() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO enfilade.loose_blobs (site_id, sha256, since) VALUES (NEW.site_id, NEW.sha256, NEW.put_time);
  RETURN NULL;
END $$;
CREATE TRIGGER list_blob AFTER INSERT ON enfilade.blobs FOR EACH ROW EXECUTE FUNCTION enfilade.list_new_blob();

-- A reference goes. The time that the blob was last put decides whether it is collected.
CREATE FUNCTION enfilade.list_blob() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO enfilade.loose_blobs (site_id, sha256, since) VALUES (OLD.site_id, OLD.sha256, '-infinity');
  RETURN NULL;
END $$;
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.map_revision_tiles FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.map_revision_tiles FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.map_layer_tiles FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.map_layer_tiles FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.map_layer_run_tiles FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.map_layer_run_tiles FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.session_record_blobs FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.session_record_blobs FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.link_point_evidence FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.link_point_evidence FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.rearrangement_blobs FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.rearrangement_blobs FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();

INSERT INTO enfilade.schema_compatibility VALUES ('loose_blobs', 'layer_runs');
COMMIT;

-- SPDX-License-Identifier: Apache-2.0
-- A site is deleted in steps, in the background. Its row is the last to go: until then its id is taken.
BEGIN;

ALTER TABLE enfilade.sites
  ADD COLUMN delete_time timestamptz,  -- when its deletion began; NULL: in use
  ADD COLUMN delete_actor text,        -- who deletes it, as the caller said
  ADD COLUMN deletion_step integer NOT NULL DEFAULT 0,  -- the one at work: storage/postgres/sites/site_deletion.cc
  ADD COLUMN deleted_rows bigint NOT NULL DEFAULT 0,    -- so far, of all tables
  ADD CONSTRAINT sites_deletion_check CHECK (
    (delete_time IS NULL) = (delete_actor IS NULL)
    AND (delete_time IS NOT NULL OR (deletion_step = 0 AND deleted_rows = 0)));
CREATE INDEX sites_deleting_idx ON enfilade.sites (site_id) WHERE delete_time IS NOT NULL;

-- Everything else of a site belongs to one of these. The lock waits for a deletion that is being marked.
CREATE FUNCTION enfilade.refuse_in_deleted_site() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  deleted timestamptz;
BEGIN
  SELECT delete_time INTO deleted FROM enfilade.sites WHERE site_id = NEW.site_id FOR KEY SHARE;
  IF deleted IS NOT NULL THEN
    RAISE EXCEPTION USING ERRCODE = 'object_not_in_prerequisite_state', CONSTRAINT = 'site_is_being_deleted',
      TABLE = TG_TABLE_NAME, SCHEMA = 'enfilade', MESSAGE = format('site %s is being deleted', NEW.site_id);
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER robots_deleted_site BEFORE INSERT ON enfilade.robots
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_in_deleted_site();
CREATE TRIGGER maps_deleted_site BEFORE INSERT ON enfilade.maps
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_in_deleted_site();
CREATE TRIGGER sessions_deleted_site BEFORE INSERT ON enfilade.sessions
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_in_deleted_site();

COMMIT;

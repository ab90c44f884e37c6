-- SPDX-License-Identifier: Apache-2.0
BEGIN;

CREATE TABLE enfilade.maps (
  site_id          enfilade.resource_id NOT NULL REFERENCES enfilade.sites,
  map_id           enfilade.resource_id NOT NULL,
  display_name     enfilade.display_name NOT NULL,
  level            integer NOT NULL DEFAULT 0,
  environment      smallint NOT NULL,
  slam_profile     text NOT NULL DEFAULT '' CHECK (char_length(slam_profile) <= 200),
  outline          geometry(Polygon, 0),  -- m, in the map's frame
  state            smallint NOT NULL DEFAULT 1,
  current_revision bigint NOT NULL DEFAULT 0 CHECK (current_revision >= 0),
  request_id       text,
  etag             bigint NOT NULL DEFAULT nextval('enfilade.etags'),
  create_time      timestamptz NOT NULL DEFAULT now(),
  update_time      timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, map_id),
  UNIQUE (site_id, display_name),
  UNIQUE (site_id, request_id),
  CONSTRAINT maps_environment_check CHECK (environment IN (1, 2)),  -- indoor, outdoor
  CONSTRAINT maps_state_check CHECK (state IN (1, 2, 3)),           -- empty, mapping, ready
  CONSTRAINT maps_empty_without_revision_check CHECK (state <> 1 OR current_revision = 0),
  CONSTRAINT maps_outline_check CHECK (outline IS NULL OR (NOT ST_IsEmpty(outline) AND ST_IsValid(outline)))
);

CREATE INDEX maps_outline_idx ON enfilade.maps USING gist (site_id, level, outline);

COMMIT;

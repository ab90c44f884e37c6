-- SPDX-License-Identifier: Apache-2.0
-- Sessions and their logs.
BEGIN;

-- The row of a deleted session stays, so that its late records are refused and its id is not used again.
CREATE TABLE enfilade.sessions (
  site_id               enfilade.resource_id NOT NULL REFERENCES enfilade.sites,
  session_id            enfilade.resource_id NOT NULL,
  robot_id              enfilade.resource_id,
  map_id                enfilade.resource_id,  -- NULL: recorded only
  state                 smallint NOT NULL DEFAULT 1,
  acknowledged_sequence bigint NOT NULL DEFAULT 0,  -- all records up to it are stored
  highest_sequence      bigint NOT NULL DEFAULT 0,
  laser_scans           bigint NOT NULL DEFAULT 0,
  odometry              bigint NOT NULL DEFAULT 0,
  images                bigint NOT NULL DEFAULT 0,
  point_clouds          bigint NOT NULL DEFAULT 0,
  withheld              bigint NOT NULL DEFAULT 0,
  payload_bytes         bigint NOT NULL DEFAULT 0,
  first_time_ns         bigint,  -- of the records, since 1970
  last_time_ns          bigint,
  error                 text,
  records_deleted       boolean NOT NULL DEFAULT false,  -- by the site's retention
  request_id            text,
  create_time           timestamptz NOT NULL DEFAULT now(),
  finish_time           timestamptz,
  delete_time           timestamptz,
  purged                boolean NOT NULL DEFAULT false,  -- its obsolete rows are deleted
  PRIMARY KEY (site_id, session_id),
  UNIQUE (site_id, request_id),
  FOREIGN KEY (site_id, robot_id) REFERENCES enfilade.robots,
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps,
  CONSTRAINT sessions_state_check CHECK (state IN (1, 2, 3, 4)),  -- recording, finished, mapped, failed
  CONSTRAINT sessions_finish_time_check CHECK (state = 4 OR (state = 1) = (finish_time IS NULL)),
  CONSTRAINT sessions_error_check CHECK ((state = 4) = (error IS NOT NULL)),
  CONSTRAINT sessions_without_holes_check CHECK (finish_time IS NULL OR acknowledged_sequence = highest_sequence),
  CONSTRAINT sessions_sequence_check CHECK (0 <= acknowledged_sequence AND acknowledged_sequence <= highest_sequence),
  CONSTRAINT sessions_count_check CHECK (
    laser_scans >= 0 AND odometry >= 0 AND images >= 0 AND point_clouds >= 0 AND withheld >= 0 AND payload_bytes >= 0
    AND laser_scans + odometry + images + point_clouds + withheld BETWEEN acknowledged_sequence AND highest_sequence),
  CONSTRAINT sessions_time_check CHECK (first_time_ns <= last_time_ns),
  -- A deleted session keeps no robot and no map from being deleted.
  CONSTRAINT sessions_robot_check CHECK ((robot_id IS NULL) = (delete_time IS NOT NULL)),
  CONSTRAINT sessions_map_check CHECK (map_id IS NULL OR delete_time IS NULL),
  CONSTRAINT sessions_purged_check CHECK (NOT purged OR delete_time IS NOT NULL OR records_deleted)
) WITH (fillfactor = 50);  -- every batch of records updates the row, in its page

CREATE INDEX sessions_newest_idx ON enfilade.sessions (site_id, create_time DESC, session_id DESC)
  WHERE delete_time IS NULL;
CREATE INDEX sessions_robot_idx ON enfilade.sessions (site_id, robot_id) WHERE robot_id IS NOT NULL;
CREATE INDEX sessions_map_idx ON enfilade.sessions (site_id, map_id) WHERE map_id IS NOT NULL;
CREATE INDEX sessions_to_map_idx ON enfilade.sessions (site_id, session_id)
  WHERE map_id IS NOT NULL AND state IN (1, 2);
CREATE INDEX sessions_to_purge_idx ON enfilade.sessions (site_id, session_id)
  WHERE (delete_time IS NOT NULL OR records_deleted) AND NOT purged;
CREATE INDEX sessions_to_expire_idx ON enfilade.sessions (site_id, finish_time)
  WHERE delete_time IS NULL AND finish_time IS NOT NULL AND NOT records_deleted AND state IN (3, 4);

-- Written by COPY while the writer has locked the session's row. That replaces the checks that a foreign key and the
-- ids' domain would repeat for every record.
CREATE TABLE enfilade.session_records (
  site_id    text COLLATE "C" NOT NULL,
  session_id text COLLATE "C" NOT NULL,
  sequence   bigint NOT NULL CHECK (sequence >= 1),
  time_ns    bigint NOT NULL,
  kind       smallint NOT NULL,  -- core/sensor/record.h: RecordKind
  payload    bytea NOT NULL,     -- core/sensor/record_codec.h
  PRIMARY KEY (site_id, session_id, sequence)
) WITH (toast_tuple_target = 8160);

-- Ranges hardly compress, and one record is read faster from its page than from a TOAST table.
ALTER TABLE enfilade.session_records ALTER COLUMN payload SET STORAGE EXTERNAL;

-- The blobs that the log refers to. A separate table costs nothing for the many records without a blob.
CREATE TABLE enfilade.session_record_blobs (
  site_id    enfilade.resource_id NOT NULL,
  session_id enfilade.resource_id NOT NULL,
  sequence   bigint NOT NULL,
  sha256     enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, session_id, sequence),
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX session_record_blobs_blob_idx ON enfilade.session_record_blobs (site_id, sha256);

COMMIT;

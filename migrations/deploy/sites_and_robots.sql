-- SPDX-License-Identifier: Apache-2.0
BEGIN;

CREATE TABLE enfilade.sites (
  site_id         enfilade.resource_id PRIMARY KEY,
  display_name    enfilade.display_name NOT NULL,
  raw_retention_s bigint CHECK (raw_retention_s >= 0),  -- NULL: records are kept for ever
  request_id      text UNIQUE,                          -- of the call that created the row (AIP-155)
  etag            bigint NOT NULL DEFAULT nextval('enfilade.etags'),
  create_time     timestamptz NOT NULL DEFAULT now(),
  update_time     timestamptz NOT NULL DEFAULT now()
);

CREATE TABLE enfilade.robots (
  site_id      enfilade.resource_id NOT NULL REFERENCES enfilade.sites,
  robot_id     enfilade.resource_id NOT NULL,
  display_name enfilade.display_name NOT NULL,
  request_id   text,
  etag         bigint NOT NULL DEFAULT nextval('enfilade.etags'),
  create_time  timestamptz NOT NULL DEFAULT now(),
  update_time  timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, robot_id),
  UNIQUE (site_id, request_id)
);

COMMIT;

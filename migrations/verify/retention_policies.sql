-- SPDX-License-Identifier: Apache-2.0
SELECT session_retention_s, revisions_kept, revision_retention_s, history_retention_s, audit_retention_s
  FROM enfilade.sites WHERE false;
SELECT tag FROM enfilade.map_revisions WHERE false;
SELECT due_time FROM enfilade.revision_reviews WHERE false;
SELECT forgotten_version FROM enfilade.site_graphs WHERE false;
SELECT 1 / count(*) FROM pg_trigger WHERE tgname = 'audit_log_kept';
SELECT 1 / count(*) FROM pg_constraint WHERE conname = 'map_layers_revision_fkey' AND convalidated;
SELECT 1 / count(*) FROM pg_index WHERE indexrelid = 'enfilade.sessions_finished_idx'::regclass AND indisvalid;
SELECT 1 / count(*) FROM pg_index WHERE indexrelid = 'enfilade.map_layers_revision_idx'::regclass AND indisvalid;

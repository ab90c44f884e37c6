-- SPDX-License-Identifier: Apache-2.0
SELECT map_id, alias_id, revision, previous_revision, actor, etag, update_time FROM enfilade.map_aliases WHERE false;

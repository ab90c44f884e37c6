-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT delete_time, delete_actor, deletion_step, deleted_rows FROM enfilade.sites WHERE false;
SELECT 'enfilade.refuse_in_deleted_site'::regproc;

ROLLBACK;

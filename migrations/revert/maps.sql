-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.maps;

COMMIT;

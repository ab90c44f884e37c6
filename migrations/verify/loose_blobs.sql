-- SPDX-License-Identifier: Apache-2.0
SELECT site_id, sha256, since, entry FROM enfilade.loose_blobs WHERE false;
SELECT site_id, listed_to FROM enfilade.blob_listings WHERE false;

// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sites/blob_collection.h"

#include <algorithm>
#include <string>
#include <vector>

#include "storage/postgres/driver/rows.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {
namespace {

// OFFSET 0 keeps each a look at an index for one blob, whatever the planner knows of the tables.
#define ENFILADE_BLOB_IS_LOOSE                                                                                         \
  " AND NOT EXISTS (SELECT FROM enfilade.map_revision_tiles r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET 0)"  \
  " AND NOT EXISTS (SELECT FROM enfilade.map_layer_tiles r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET 0)"     \
  " AND NOT EXISTS (SELECT FROM enfilade.map_layer_run_tiles r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET 0)" \
  " AND NOT EXISTS (SELECT FROM enfilade.raster_pyramid_tiles r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET "  \
  "0)"                                                                                                                 \
  " AND NOT EXISTS (SELECT FROM enfilade.map_overlay_tiles r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET 0)"   \
  " AND NOT EXISTS (SELECT FROM enfilade.prior_map_files r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET 0)"     \
  " AND NOT EXISTS (SELECT FROM enfilade.session_record_blobs r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET "  \
  "0)"                                                                                                                 \
  " AND NOT EXISTS (SELECT FROM enfilade.link_point_evidence r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET 0)" \
  " AND NOT EXISTS (SELECT FROM enfilade.rearrangement_blobs r WHERE r.site_id = $1 AND r.sha256 = b.sha256 OFFSET 0)"

constexpr Statement kTakeLoose{"taking blobs that may be unused",
                               "DELETE FROM enfilade.loose_blobs WHERE site_id = $1 AND ctid = ANY (ARRAY("
                               "  SELECT ctid FROM enfilade.loose_blobs WHERE site_id = $1"
                               "  AND since <= now() - $2 * interval '1 second' ORDER BY since LIMIT $3"
                               "  FOR UPDATE SKIP LOCKED)) RETURNING sha256"};
// Who is about to refer to a blob has locked it. It stays, and it is looked at again.
constexpr Statement kLockUnused{"locking unused blobs",
                                "SELECT b.sha256 FROM enfilade.blobs b WHERE b.site_id = $1 AND b.sha256 = ANY ($2)"
                                " AND b.put_time <= now() - $3 * interval '1 second'" ENFILADE_BLOB_IS_LOOSE
                                " ORDER BY b.sha256 FOR UPDATE SKIP LOCKED"};
// Looks again, now that nobody can add a reference.
constexpr Statement kDeleteUnused{"deleting unused blobs",
                                  "DELETE FROM enfilade.blobs b WHERE b.site_id = $1"
                                  " AND b.sha256 = ANY ($2)" ENFILADE_BLOB_IS_LOOSE};
// What is unused and was not deleted, because it was put lately or is locked. A blob that is in use is no longer
// listed: whoever removes its last reference lists it again.
constexpr Statement kListAgain{
    "listing blobs that may be unused",
    "INSERT INTO enfilade.loose_blobs (site_id, sha256, since) SELECT $1, b.sha256, now() FROM enfilade.blobs b"
    " WHERE b.site_id = $1 AND b.sha256 = ANY ($2)" ENFILADE_BLOB_IS_LOOSE};

constexpr Statement kLockListing{
    "continuing the list of blobs",
    "SELECT listed_to FROM enfilade.blob_listings WHERE site_id = $1 FOR UPDATE SKIP LOCKED"};
constexpr Statement kListNext{"listing stored blobs",
                              "INSERT INTO enfilade.loose_blobs (site_id, sha256, since)"
                              " SELECT $1, sha256, put_time FROM enfilade.blobs WHERE site_id = $1 AND sha256 > $2"
                              " ORDER BY sha256 LIMIT $3 RETURNING sha256"};
constexpr Statement kMarkListed{"continuing the list of blobs",
                                "UPDATE enfilade.blob_listings SET listed_to = $2 WHERE site_id = $1"};
constexpr Statement kEndListing{"ending the list of blobs", "DELETE FROM enfilade.blob_listings WHERE site_id = $1"};

absl::StatusOr<std::vector<std::string>> ReadDigests(const Result& result) {
  return ReadRows(result, [](Row& row) { return std::string(row.Bytes()); });
}

std::vector<Bytes> AsBytes(const std::vector<std::string>& digests) {
  std::vector<Bytes> bytes;
  for (const std::string& digest : digests) bytes.push_back(Bytes{digest});
  return bytes;
}

absl::StatusOr<MaintenancePortion> LookAtListed(Pool& pool, const CallContext& context, const SiteId& site,
                                                std::int64_t grace_s, std::int64_t limit) {
  MaintenancePortion collection;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const Result taken, transaction.Execute(kTakeLoose, Params(site, grace_s, limit)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> listed, ReadDigests(taken));
  collection.looked_at = static_cast<std::int64_t>(listed.size());
  if (listed.empty()) return collection;
  ENFILADE_ASSIGN_OR_RETURN(const Result locked,
                            transaction.Execute(kLockUnused, Params(site, AsBytes(listed), grace_s)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> unused, ReadDigests(locked));
  if (!unused.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const Result deleted, transaction.Execute(kDeleteUnused, Params(site, AsBytes(unused))));
    collection.deleted = deleted.affected();
  }
  transaction.Queue(kListAgain, Params(site, AsBytes(listed)));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return collection;
}

// Lists the next blobs that were stored before there was a list. Returns how many.
absl::StatusOr<std::int64_t> ListStored(Pool& pool, const CallContext& context, const SiteId& site,
                                        std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const Result listing, transaction.Execute(kLockListing, Params(site)));
  if (listing.rows() == 0) return 0;  // all are listed, or another replica is listing them
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> listed_to, ReadDigests(listing));
  ENFILADE_ASSIGN_OR_RETURN(const Result next,
                            transaction.Execute(kListNext, Params(site, Bytes{listed_to.front()}, limit)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> listed, ReadDigests(next));
  if (static_cast<std::int64_t>(listed.size()) < limit) {
    transaction.Queue(kEndListing, Params(site));
  } else {
    transaction.Queue(kMarkListed, Params(site, Bytes{*std::max_element(listed.begin(), listed.end())}));
  }
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return static_cast<std::int64_t>(listed.size());
}

}  // namespace

absl::StatusOr<MaintenancePortion> CollectBlobsOf(Pool& pool, const CallContext& context, const SiteId& site,
                                                  std::chrono::seconds grace, std::int64_t limit) {
  ENFILADE_ASSIGN_OR_RETURN(MaintenancePortion collection,
                            LookAtListed(pool, context, site, static_cast<std::int64_t>(grace.count()), limit));
  if (collection.looked_at < limit) {
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t listed, ListStored(pool, context, site, limit - collection.looked_at));
    collection.looked_at += listed;
  }
  return collection;
}

}  // namespace enfilade::storage::postgres

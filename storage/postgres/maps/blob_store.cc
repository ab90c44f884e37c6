// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/blob_store.h"

#include <algorithm>

#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

// Writes an existing row only if its grace period has to be renewed.
constexpr Statement kPutBlob{"storing a blob",
                             "INSERT INTO enfilade.blobs AS b (site_id, sha256, data) VALUES ($1, $2, $3)"
                             " ON CONFLICT (site_id, sha256) DO UPDATE SET put_time = excluded.put_time"
                             " WHERE excluded.put_time - b.put_time > interval '1 minute'"};
constexpr Statement kSelectBlob{"reading the blob",
                                "SELECT data FROM enfilade.blobs WHERE site_id = $1 AND sha256 = $2"};
constexpr Statement kSelectBlobs{"reading blobs",
                                 "SELECT sha256, data FROM enfilade.blobs WHERE site_id = $1 AND sha256 = ANY ($2)"};

std::string NameOfBlob(const SiteId& site, std::string_view sha256) {
  return fmt::format("blob {} of {}", ToHex(sha256), NameOf(site));
}

}  // namespace

void QueueBlobs(Transaction& transaction, const SiteId& site, absl::Span<const BlobView> blobs) {
  // In the same order everywhere, to avoid deadlocks.
  std::vector<const BlobView*> ordered;
  for (const BlobView& blob : blobs) ordered.push_back(&blob);
  std::sort(ordered.begin(), ordered.end(), [](auto* a, auto* b) { return a->sha256 < b->sha256; });
  for (const BlobView* blob : ordered) {
    transaction.Queue(kPutBlob, Params(site, Bytes{blob->sha256}, Bytes{blob->data}));
  }
}

absl::Status BlobStore::Put(const CallContext& context, const SiteId& site, absl::Span<const BlobView> blobs) const {
  ENFILADE_RETURN_IF_ERROR(ValidateBlobs(blobs));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  QueueBlobs(transaction, site, blobs);
  absl::Status committed = transaction.Commit();
  if (SqlStateOf(committed) == "23503") return NotFound("{} does not exist", NameOf(site));
  return committed;
}

absl::StatusOr<std::string> BlobStore::Get(const CallContext& context, const SiteId& site,
                                           std::string_view sha256) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectBlob, Params(site, Bytes{sha256})));
  return ReadOne(
      result, [](Row& row) { return std::string(row.Bytes()); }, NameOfBlob(site, sha256));
}

absl::StatusOr<std::map<std::string, std::string>> BlobStore::GetAll(const CallContext& context, const SiteId& site,
                                                                     const std::vector<std::string>& sha256) const {
  std::vector<Bytes> digests;
  digests.reserve(sha256.size());
  for (const std::string& digest : sha256) digests.push_back(Bytes{digest});
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectBlobs, Params(site, digests)));
  std::map<std::string, std::string> blobs;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    std::string digest(row.Bytes());
    blobs.emplace(std::move(digest), std::string(row.Bytes()));
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  for (const std::string& digest : sha256) {
    if (!blobs.contains(digest)) return NotFound("{} does not exist", NameOfBlob(site, digest));
  }
  return blobs;
}

}  // namespace enfilade::storage::postgres

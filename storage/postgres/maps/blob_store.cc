// SPDX-License-Identifier: Apache-2.0
#include "storage/blob_store.h"

#include <algorithm>

#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/blob_rows.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

// Touches a row only where its grace time is due to be renewed.
constexpr Statement kPutBlob{"storing a blob",
                             "INSERT INTO enfilade.blobs AS b (site_id, sha256, data) VALUES ($1, $2, $3)"
                             " ON CONFLICT (site_id, sha256) DO UPDATE SET put_time = now()"
                             " WHERE b.put_time < now() - interval '1 minute'"};
constexpr Statement kSelectBlob{"reading the blob",
                                "SELECT data FROM enfilade.blobs WHERE site_id = $1 AND sha256 = $2"};
constexpr Statement kSelectRange{
    "reading a part of the blob",
    "SELECT size, substring(data FROM $3 FOR $4) FROM enfilade.blobs WHERE site_id = $1 AND sha256 = $2"};
constexpr Statement kStat{"looking for the blob", "SELECT size FROM enfilade.blobs WHERE site_id = $1 AND sha256 = $2"};
constexpr Statement kMissing{"looking for blobs",
                             "SELECT DISTINCT u.sha256 FROM unnest($2::bytea[]) AS u (sha256) WHERE NOT EXISTS"
                             " (SELECT FROM enfilade.blobs b WHERE b.site_id = $1 AND b.sha256 = u.sha256)"};

std::string NameOfBlob(const SiteId& site, std::string_view sha256) {
  return fmt::format("blob {} of {}", ToHex(sha256), NameOf(site));
}

}  // namespace

namespace postgres {

absl::Status ValidateBlobs(absl::Span<const BlobView> blobs) {
  for (const BlobView& blob : blobs) {
    if (blob.data.empty() || static_cast<std::int64_t>(blob.data.size()) > sensor::kMaxBlobBytes) {
      return InvalidArgument("a blob has {} bytes: expected 1 to {}", blob.data.size(), sensor::kMaxBlobBytes);
    }
    if (const std::string digest = Sha256(blob.data); digest != blob.sha256) {
      return InvalidArgument("a blob's SHA-256 is {}, not {} as was said", ToHex(digest), ToHex(blob.sha256));
    }
  }
  return absl::OkStatus();
}

void QueueBlobs(storage::postgres::Transaction& transaction, const SiteId& site, absl::Span<const BlobView> blobs) {
  // In one order everywhere, against deadlocks.
  std::vector<const BlobView*> ordered;
  for (const BlobView& blob : blobs) ordered.push_back(&blob);
  std::sort(ordered.begin(), ordered.end(), [](auto* a, auto* b) { return a->sha256 < b->sha256; });
  for (const BlobView* blob : ordered)
    transaction.Queue(kPutBlob, storage::postgres::Params(site, storage::postgres::Bytes{blob->sha256},
                                                          storage::postgres::Bytes{blob->data}));
}

}  // namespace postgres

absl::Status BlobStore::Put(const CallContext& context, const SiteId& site, absl::Span<const BlobView> blobs) const {
  ENFILADE_RETURN_IF_ERROR(postgres::ValidateBlobs(blobs));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  postgres::QueueBlobs(transaction, site, blobs);
  const absl::Status committed = transaction.Commit();
  if (postgres::SqlStateOf(committed) == "23503") return NotFound("{} does not exist", NameOf(site));
  return committed;
}

absl::StatusOr<std::string> BlobStore::Get(const CallContext& context, const SiteId& site,
                                           std::string_view sha256) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kSelectBlob, Params(site, Bytes{sha256})));
  return storage::postgres::ReadOne(
      result, [](Row& row) { return std::string(row.Bytes()); }, NameOfBlob(site, sha256));
}

absl::StatusOr<std::string> BlobStore::GetRange(const CallContext& context, const SiteId& site, std::string_view sha256,
                                                std::int64_t offset, std::int64_t size) const {
  if (offset < 0 || size < 0 || offset > sensor::kMaxBlobBytes) {
    return absl::OutOfRangeError(fmt::format("there is no part of {} bytes at {} of a blob", size, offset));
  }
  const auto first = static_cast<std::int32_t>(offset + 1);  // counted from 1
  const auto count = static_cast<std::int32_t>(std::min(size, sensor::kMaxBlobBytes));
  ENFILADE_ASSIGN_OR_RETURN(
      const auto result,
      storage::postgres::ExecuteAlone(pool_, context, kSelectRange, Params(site, Bytes{sha256}, first, count)));
  std::int64_t stored_size = 0;
  ENFILADE_ASSIGN_OR_RETURN(std::string data, storage::postgres::ReadOne(
                                                  result,
                                                  [&](Row& row) {
                                                    stored_size = row.Int64();
                                                    return std::string(row.Bytes());
                                                  },
                                                  NameOfBlob(site, sha256)));
  if (offset > stored_size) {
    return absl::OutOfRangeError(
        fmt::format("{} ends at {}, before {}", NameOfBlob(site, sha256), stored_size, offset));
  }
  return data;
}

absl::StatusOr<sensor::BlobRef> BlobStore::Stat(const CallContext& context, const SiteId& site,
                                                std::string_view sha256) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kStat, Params(site, Bytes{sha256})));
  return storage::postgres::ReadOne(
      result,
      [&](Row& row) {
        return sensor::BlobRef{std::string(sha256), row.Int64()};
      },
      NameOfBlob(site, sha256));
}

absl::StatusOr<std::vector<std::string>> BlobStore::Missing(const CallContext& context, const SiteId& site,
                                                            absl::Span<const std::string> sha256s) const {
  std::vector<Bytes> digests;
  for (const std::string& sha256 : sha256s) digests.push_back(Bytes{sha256});
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kMissing, Params(site, digests)));
  return storage::postgres::ReadRows(result, [](Row& row) { return std::string(row.Bytes()); });
}

}  // namespace enfilade::storage

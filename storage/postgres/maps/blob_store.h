// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/maps/blob_store.h"
#include "storage/postgres/driver/pool.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Stores validated blobs and renews the grace period of those that are already stored. Queued only.
void QueueBlobs(Transaction& transaction, const SiteId& site, absl::Span<const BlobView> blobs);

class BlobStore final : public storage::BlobStore {
 public:
  explicit BlobStore(Pool& pool) : pool_(pool) {}

  absl::Status Put(const CallContext& context, const SiteId& site, absl::Span<const BlobView> blobs) const override;
  absl::StatusOr<std::string> Get(const CallContext& context, const SiteId& site,
                                  std::string_view sha256) const override;
  absl::StatusOr<std::map<std::string, std::string>> GetAll(const CallContext& context, const SiteId& site,
                                                            const std::vector<std::string>& sha256) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres

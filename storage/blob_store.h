// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/sensor/record.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// Bytes to be stored under their digest. The views must live until the call returns.
struct BlobView {
  std::string_view sha256;  // 32 raw bytes
  std::string_view data;    // 1 byte to kMaxBlobBytes
};

// Content-addressed bytes of a site: sent twice, stored once. What nothing refers to is collected by Maintenance
// after a grace time that starts anew whenever the same bytes are put again. Thread-safe; errors common to all stores:
// see SiteStore.
class BlobStore {
 public:
  explicit BlobStore(postgres::Pool& pool) : pool_(pool) {}

  // Idempotent, all or nothing. INVALID_ARGUMENT where a digest is not that of its data, or the size is out of range;
  // NOT_FOUND where the site is missing.
  absl::Status Put(const CallContext& context, const SiteId& site, absl::Span<const BlobView> blobs) const;
  // NOT_FOUND.
  absl::StatusOr<std::string> Get(const CallContext& context, const SiteId& site, std::string_view sha256) const;
  // `size` bytes from `offset`, fewer at the end. NOT_FOUND; OUT_OF_RANGE where `offset` is beyond the end.
  absl::StatusOr<std::string> GetRange(const CallContext& context, const SiteId& site, std::string_view sha256,
                                       std::int64_t offset, std::int64_t size) const;
  // The blob with its size. NOT_FOUND.
  absl::StatusOr<sensor::BlobRef> Stat(const CallContext& context, const SiteId& site, std::string_view sha256) const;
  // Those of `sha256s` that the site does not have, each once.
  absl::StatusOr<std::vector<std::string>> Missing(const CallContext& context, const SiteId& site,
                                                   absl::Span<const std::string> sha256s) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage

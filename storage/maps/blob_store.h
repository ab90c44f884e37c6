// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
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

// Bytes to be stored under their digest. The views must live until the call returns.
struct BlobView {
  std::string_view sha256;  // 32 raw bytes
  std::string_view data;    // 1 byte to kMaxBlobBytes
};

// INVALID_ARGUMENT if a digest is not that of its data, or a size is out of range.
absl::Status ValidateBlobs(absl::Span<const BlobView> blobs);

// Content-addressed bytes of a site: the same bytes are stored once. Maintenance collects blobs without references
// after a grace period, which starts again whenever the same bytes are put. Thread-safe; errors common to all stores:
// see SiteStore.
class BlobStore {
 public:
  virtual ~BlobStore() = default;

  // Stores all or nothing. Idempotent. INVALID_ARGUMENT as in ValidateBlobs; NOT_FOUND if the site does not exist.
  virtual absl::Status Put(const CallContext& context, const SiteId& site, absl::Span<const BlobView> blobs) const = 0;
  // NOT_FOUND.
  virtual absl::StatusOr<std::string> Get(const CallContext& context, const SiteId& site,
                                          std::string_view sha256) const = 0;
  // The bytes of each of `sha256`, by digest: all in memory, so ask for portions. NOT_FOUND naming one that is missing.
  virtual absl::StatusOr<std::map<std::string, std::string>> GetAll(const CallContext& context, const SiteId& site,
                                                                    const std::vector<std::string>& sha256) const;
};

}  // namespace enfilade::storage

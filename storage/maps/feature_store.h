// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// Features of stored images (perception/image/feature_codec.h). They are deleted with the image.
// Thread-safe; errors common to all stores: see SiteStore.
class FeatureStore {
 public:
  explicit FeatureStore(postgres::Pool& pool) : pool_(pool) {}

  // Empty if the image has no stored features.
  absl::StatusOr<std::string> Find(const CallContext& context, const SiteId& site, std::string_view sha256) const;
  // Replaces the stored features. No-op if the image does not exist.
  absl::Status Put(const CallContext& context, const SiteId& site, std::string_view sha256,
                   std::string_view features) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage

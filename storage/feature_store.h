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

// What was found in stored images (perception/image/feature_codec.h), beside them: it goes when the image goes.
// Thread-safe; errors common to all stores: see SiteStore.
class FeatureStore {
 public:
  explicit FeatureStore(postgres::Pool& pool) : pool_(pool) {}

  // Empty where nothing is kept of the image.
  absl::StatusOr<std::string> Find(const CallContext& context, const SiteId& site, std::string_view sha256) const;
  // Takes the place of what was kept. Nothing happens where there is no such image.
  absl::Status Put(const CallContext& context, const SiteId& site, std::string_view sha256,
                   std::string_view features) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage

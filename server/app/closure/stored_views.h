// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/sensor/record.h"
#include "perception/cloud/cloud.h"
#include "perception/image/features.h"
#include "server/app/closure/closure_stores.h"

namespace enfilade::server {

// Stored images' features and stored clouds, read once each while one report is judged. What cannot be read (damaged,
// too large, nothing to see) is as if it were not there; why is told by Faults. Errors are the stores' and go_on's
// alone.
class StoredViews {
 public:
  // `go_on` is asked before each image that features are looked for in: it takes long.
  StoredViews(const DoorClosureStores& stores, const SiteId& site, const closure::DoorClosureOptions& options,
              std::function<absl::Status()> go_on)
      : stores_(stores), site_(site), options_(options), go_on_(std::move(go_on)) {}

  // Null where there is nothing to see in it. `keep`: its features are read from the database or stored there, for
  // images that are compared more than once.
  absl::StatusOr<const perception::FeatureSet*> Features(const storage::CallContext& context,
                                                         const sensor::BlobRef& image, bool keep);
  // Null where it has no points, or is none.
  absl::StatusOr<const perception::Cloud*> Points(const storage::CallContext& context, const sensor::BlobRef& cloud,
                                                  sensor::CloudEncoding encoding);

  // What could not be read, in words; empty where all could.
  std::string Faults() const;

 private:
  absl::StatusOr<std::optional<perception::FeatureSet>> FindFeatures(const storage::CallContext& context,
                                                                     const sensor::BlobRef& image, bool keep);
  void AddFault(const std::string& what);

  const DoorClosureStores& stores_;
  const SiteId& site_;
  const closure::DoorClosureOptions& options_;
  const std::function<absl::Status()> go_on_;
  std::map<std::string, std::optional<perception::FeatureSet>> features_;  // by SHA-256
  std::map<std::string, std::optional<perception::Cloud>> clouds_;
  std::map<std::string, int> faults_;  // how often
};

}  // namespace enfilade::server

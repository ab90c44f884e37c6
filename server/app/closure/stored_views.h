// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/sensor/record.h"
#include "perception/cloud/cloud.h"
#include "perception/image/features.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/judging_lease.h"

namespace enfilade::server {

// The features of stored images and the points of stored clouds, each read once while one report is judged. Content
// that cannot be used (damaged, too large, showing nothing) counts as missing; Faults says why. Errors are the stores'
// and the lease's.
class StoredViews {
 public:
  // All must outlive it. The lease is renewed before features are extracted, which takes long.
  StoredViews(const DoorClosureStores& stores, const JudgingLease& lease, const closure::DoorClosureOptions& options)
      : stores_(stores), lease_(lease), options_(options) {}

  // Null if the image shows nothing. `keep`: its features are read from the database or stored there, for images that
  // are compared more than once.
  absl::StatusOr<const perception::FeatureSet*> Features(const sensor::BlobRef& image, bool keep);
  // Null if it is not a cloud or has too few points.
  absl::StatusOr<const perception::Cloud*> Points(const sensor::BlobRef& cloud, sensor::CloudEncoding encoding);

  // What could not be read and why, as text; empty if everything could.
  std::string Faults() const;

 private:
  absl::StatusOr<std::optional<perception::FeatureSet>> FindFeatures(const sensor::BlobRef& image, bool keep);
  void AddFault(const std::string& what);

  const DoorClosureStores& stores_;
  const JudgingLease& lease_;
  const closure::DoorClosureOptions& options_;
  std::map<std::string, std::optional<perception::FeatureSet>> features_;  // by SHA-256
  std::map<std::string, std::optional<perception::Cloud>> clouds_;
  std::map<std::string, int> faults_;  // how often each occurred
};

}  // namespace enfilade::server

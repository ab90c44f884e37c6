// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/stored_views.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "perception/cloud/decode_cloud.h"
#include "perception/image/decode.h"
#include "perception/image/feature_codec.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kMinPoints = 50;

int CountOf(const perception::FeatureSet& features) {
  return static_cast<int>(features.sift.size() + features.akaze.size());
}

}  // namespace

void StoredViews::AddFault(const std::string& what) { ++faults_[what]; }

std::string StoredViews::Faults() const {
  std::string text;
  for (const auto& [what, times] : faults_) {
    text += (text.empty() ? "" : "; ") + what;
    if (times > 1) text += fmt::format(" ({} times)", times);
  }
  return text;
}

absl::StatusOr<std::optional<perception::FeatureSet>> StoredViews::FindFeatures(const sensor::BlobRef& image,
                                                                                bool keep) {
  if (keep) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string kept,
                              stores_.features.Find(JudgingLease::Context(), lease_.site(), image.sha256));
    if (!kept.empty()) {
      auto decoded = perception::DecodeFeatures(kept);
      if (decoded.ok()) return std::optional<perception::FeatureSet>(*std::move(decoded));
    }
  }
  ENFILADE_RETURN_IF_ERROR(lease_.Renew());
  const auto bytes = stores_.blobs.Get(JudgingLease::Context(), lease_.site(), image.sha256);
  if (!bytes.ok() && !absl::IsNotFound(bytes.status())) return bytes.status();
  const auto frame = bytes.ok() ? perception::DecodeGrey(*bytes) : bytes.status();
  auto found = frame.ok() ? perception::ExtractFeatures(*frame) : frame.status();
  if (!found.ok()) {
    AddFault("an image cannot be read: " + std::string(found.status().message()));
    return std::optional<perception::FeatureSet>();
  }
  perception::FeatureSet features = *std::move(found);
  if (keep) {
    ENFILADE_RETURN_IF_ERROR(stores_.features.Put(JudgingLease::Context(), lease_.site(), image.sha256,
                                                  perception::EncodeFeatures(features)));
  }
  return std::optional<perception::FeatureSet>(std::move(features));
}

absl::StatusOr<const perception::FeatureSet*> StoredViews::Features(const sensor::BlobRef& image, bool keep) {
  auto found = features_.find(image.sha256);
  if (found == features_.end()) {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<perception::FeatureSet> features, FindFeatures(image, keep));
    if (features && CountOf(*features) < options_.min_features) {
      AddFault(fmt::format("an image shows nothing: {} features", CountOf(*features)));
      features.reset();
    }
    found = features_.emplace(image.sha256, std::move(features)).first;
  }
  return found->second ? &*found->second : nullptr;
}

absl::StatusOr<const perception::Cloud*> StoredViews::Points(const sensor::BlobRef& cloud,
                                                             sensor::CloudEncoding encoding) {
  auto found = clouds_.find(cloud.sha256);
  if (found == clouds_.end()) {
    const auto bytes = stores_.blobs.Get(JudgingLease::Context(), lease_.site(), cloud.sha256);
    if (!bytes.ok() && !absl::IsNotFound(bytes.status())) return bytes.status();
    const auto decode = encoding == sensor::CloudEncoding::kXyz32 ? perception::DecodeXyz32 : perception::DecodePcd;
    const auto decoded = bytes.ok() ? decode(*bytes) : bytes.status();
    std::optional<perception::Cloud> points;
    if (!decoded.ok()) {
      AddFault("a cloud cannot be read: " + std::string(decoded.status().message()));
    } else {
      perception::Cloud finite = perception::FinitePoints(*decoded);
      if (finite.points.size() < kMinPoints) {
        AddFault(fmt::format("a cloud has {} points", finite.points.size()));
      } else {
        points = std::move(finite);
      }
    }
    found = clouds_.emplace(cloud.sha256, std::move(points)).first;
  }
  return found->second ? &*found->second : nullptr;
}

}  // namespace enfilade::server

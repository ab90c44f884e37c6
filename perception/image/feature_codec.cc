// SPDX-License-Identifier: Apache-2.0
#include "perception/image/feature_codec.h"

#include <cmath>
#include <cstddef>

#include "core/base/binary.h"
#include "core/base/error.h"

namespace enfilade::perception {
namespace {

// Incremented whenever the layout or the extraction changes.
constexpr std::uint8_t kVersion = 1;
constexpr int kMaxSide = 1 << 20;

void Put(const std::vector<Keypoint>& keypoints, const std::vector<std::uint8_t>& descriptors, BinaryWriter& writer) {
  writer.Put<std::uint64_t>(keypoints.size());
  for (const Keypoint& keypoint : keypoints) {
    writer.Put(keypoint.x);
    writer.Put(keypoint.y);
    writer.Put(keypoint.size);
    writer.Put(keypoint.angle);
  }
  writer.PutVector(descriptors);
}

bool Get(BinaryReader& reader, std::size_t descriptor_bytes, std::vector<Keypoint>& keypoints,
         std::vector<std::uint8_t>& descriptors) {
  const auto count = reader.Get<std::uint64_t>();
  if (!reader.ok() || count > reader.remaining() / (4 * sizeof(float))) return false;
  keypoints.resize(count);
  for (Keypoint& keypoint : keypoints) {
    keypoint.x = reader.Get<float>();
    keypoint.y = reader.Get<float>();
    keypoint.size = reader.Get<float>();
    keypoint.angle = reader.Get<float>();
    if (!std::isfinite(keypoint.x) || !std::isfinite(keypoint.y) || !std::isfinite(keypoint.angle) ||
        !(keypoint.size > 0.0F) || !std::isfinite(keypoint.size)) {
      return false;
    }
  }
  descriptors = reader.GetVector<std::uint8_t>();
  return reader.ok() && descriptors.size() == count * descriptor_bytes;
}

}  // namespace

std::string EncodeFeatures(const FeatureSet& features) {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put(kVersion);
  writer.Put<std::int32_t>(features.width);
  writer.Put<std::int32_t>(features.height);
  Put(features.sift, features.sift_descriptors, writer);
  Put(features.akaze, features.akaze_descriptors, writer);
  return bytes;
}

absl::StatusOr<FeatureSet> DecodeFeatures(std::string_view bytes) {
  BinaryReader reader(bytes);
  if (const auto version = reader.Get<std::uint8_t>(); version != kVersion) {
    return DataLoss("image features: version {} is unknown to this program (expected {})", version, kVersion);
  }
  FeatureSet features;
  features.width = reader.Get<std::int32_t>();
  features.height = reader.Get<std::int32_t>();
  if (features.width <= 0 || features.height <= 0 || features.width > kMaxSide || features.height > kMaxSide) {
    return DataLoss("image features: of an image of {}x{} pixels", features.width, features.height);
  }
  if (!Get(reader, kSiftBytes, features.sift, features.sift_descriptors) ||
      !Get(reader, kAkazeBytes, features.akaze, features.akaze_descriptors) || !reader.at_end()) {
    return DataLoss("image features: {} bytes are damaged or truncated", bytes.size());
  }
  return features;
}

}  // namespace enfilade::perception

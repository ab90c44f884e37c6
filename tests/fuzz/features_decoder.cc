// SPDX-License-Identifier: Apache-2.0
// Image features as stored beside their image.
#include "perception/image/feature_codec.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  perception::FeatureSet features;
  features.width = 64;
  features.height = 48;
  const std::string empty = perception::EncodeFeatures(features);
  features.sift = {{1.0F, 2.0F, 3.0F, 0.5F}, {10.0F, 20.0F, 4.0F, 6.0F}};
  features.sift_descriptors.assign(2 * perception::kSiftBytes, 7);
  features.akaze = {{5.0F, 6.0F, 7.0F, 1.0F}};
  features.akaze_descriptors.assign(perception::kAkazeBytes, 9);
  return {empty, perception::EncodeFeatures(features)};
}

bool Decode(std::string_view bytes) {
  const auto features = perception::DecodeFeatures(bytes);
  if (!features.ok()) return false;
  Expect(features->sift_descriptors.size() == features->sift.size() * perception::kSiftBytes &&
             features->akaze_descriptors.size() == features->akaze.size() * perception::kAkazeBytes,
         "a descriptor for each keypoint");
  Expect(perception::EncodeFeatures(*features) == bytes, "features are written as they were read");
  return true;
}

}  // namespace enfilade::fuzz

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "perception/image/features.h"

namespace enfilade::perception {

// Serialises features for storage beside their image: little-endian, a version byte first, exact. An image of a
// corridor with 512x384 pixels takes about 40 KiB.
std::string EncodeFeatures(const FeatureSet& features);

// DATA_LOSS: another version (then extract the features again), truncated or trailing bytes, impossible values. Never
// allocates more than `bytes` holds.
absl::StatusOr<FeatureSet> DecodeFeatures(std::string_view bytes);

}  // namespace enfilade::perception

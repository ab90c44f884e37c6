// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "perception/image/features.h"

namespace enfilade::perception {

// Features as bytes, to be stored beside their image: little-endian, a version byte first, exact. 512x384 pixels of a
// corridor take about 40 KiB.
std::string EncodeFeatures(const FeatureSet& features);

// DATA_LOSS on another version (features are made anew from the image then) and on truncated, trailing or impossible
// content; nothing larger than `bytes` is allocated before it is checked.
absl::StatusOr<FeatureSet> DecodeFeatures(std::string_view bytes);

}  // namespace enfilade::perception

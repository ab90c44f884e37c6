// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {

// Occupancy values as in ROS nav_msgs/OccupancyGrid, and their conversion from and to grey images by Nav2's and ROS 1's
// map_server. Sources: map_io.cpp of nav2_map_server (2025), image_loader.cpp of ROS 1's map_server.
constexpr std::uint8_t kOpaqueAlpha = 255;
constexpr std::int8_t kUnknownValue = -1;  // 0 free ... 100 occupied

// Loading. `grey` is 0..255; `alpha` 255 = opaque, unset if the image has no alpha channel.
//
// Nav2, in single precision: p = grey / 255, and 1 - p unless negate. trinary: p >= occupied_thresh: 100; p <=
// free_thresh: 0 (takes precedence if both hold); otherwise unknown. scale: the same ends, round(100 (p - free) /
// (occupied - free)) in between. Pixels that are not opaque are unknown. raw: the grey is the value, unknown above 100;
// negate and alpha are ignored.
//
// ROS 1, in double precision: > and < instead; scale in between: 1 + 98 (p - free) / (occupied - free), truncated, and
// unknown if fully transparent; trinary averages alpha in as a fourth colour; raw honours negate.
std::int8_t LoadedValue(const GreyInterpretation& interpretation, int grey, std::optional<int> alpha = std::nullopt);

// The value of each grey level of an image without alpha whose white is `max_value`. Greys are first scaled to 0..255
// and rounded, as in Nav2's image library.
std::array<std::int8_t, 256> LoadedValues(const GreyInterpretation& interpretation, int max_value);

// Saving, as in Nav2.
struct GreySaveOptions {
  MapMode mode = MapMode::kTrinary;
  double occupied_thresh = 0.65;
  double free_thresh = 0.25;

  // INVALID_ARGUMENT unless 0 <= free_thresh < occupied_thresh <= 1.
  absl::Status Validate() const;
};

struct GreyAlpha {
  std::uint8_t grey = 0;
  std::uint8_t alpha = 255;

  friend bool operator==(const GreyAlpha&, const GreyAlpha&) = default;
};

// trinary: 254 up to round(100 free_thresh), 0 from round(100 occupied_thresh), 205 otherwise. scale: (100 - value) /
// 100 of white; unknown is mid-grey and transparent. raw: the value; unknown is 255.
GreyAlpha SavedGrey(const GreySaveOptions& options, std::int8_t value);

// How to read images written by SavedGrey: trinary always with 0.65 and 0.196, which separate 0, 205 and 254 whatever
// the thresholds were; negate false.
GreyInterpretation InterpretationOfSaved(const GreySaveOptions& options);

// Conversion between occupancy values and cells of an OccupancyGrid; value -> cell -> value is the identity.
std::uint8_t CellFromOccupancyValue(std::int8_t value);
std::int8_t OccupancyValueOfCell(std::uint8_t cell);

}  // namespace enfilade::grid

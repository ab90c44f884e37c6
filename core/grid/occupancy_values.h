// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {

// The occupancy values of ROS' nav_msgs/OccupancyGrid, and how Nav2's map_server (and ROS 1's) makes them from grey
// images and back. Source: nav2_map_server's map_io.cpp as of 2025; ROS 1: map_server's image_loader.cpp.
constexpr std::uint8_t kOpaqueAlpha = 255;
constexpr std::int8_t kUnknownValue = -1;  // 0 free ... 100 occupied

// Loading. `grey` is 0..255; `alpha` 255 = opaque, unset where the image has no alpha channel.
//
// Nav2, in single precision: p = grey / 255, and 1 - p unless negate. trinary: p >= occupied_thresh: 100; p <=
// free_thresh: 0 (which wins where both hold); else unknown. scale: the same ends, round(100 (p - free) / (occupied -
// free)) in between. Anything not opaque is unknown. raw: the grey is the value, unknown above 100; negate and alpha
// do not matter.
//
// ROS 1, in double precision: > and < instead; scale in between: 1 + 98 (p - free) / (occupied - free), cut to an
// integer, and unknown where fully transparent; trinary takes alpha for a fourth colour; raw obeys negate.
std::int8_t LoadedValue(const GreyInterpretation& interpretation, int grey, std::optional<int> alpha = std::nullopt);

// By grey level, for images whose white is `max_value` (greys are scaled to 0..255 and rounded first, as Nav2's image
// library does), without an alpha channel.
std::array<std::int8_t, 256> LoadedValues(const GreyInterpretation& interpretation, int max_value);

// Saving, as Nav2 does.
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

// trinary: at or below round(100 free_thresh): 254; at or above round(100 occupied_thresh): 0; else 205. scale: (100 -
// value) / 100 of white; unknown: half grey and transparent. raw: the value; unknown: 255.
GreyAlpha SavedGrey(const GreySaveOptions& options, std::int8_t value);

// How images written by SavedGrey are to be read: trinary always with 0.65 and 0.196, which separate 0, 205 and 254
// whatever thresholds made them; negate false.
GreyInterpretation InterpretationOfSaved(const GreySaveOptions& options);

// Between occupancy values and the cells of an OccupancyGrid; value -> cell -> value is the identity.
std::uint8_t CellFromOccupancyValue(std::int8_t value);
std::int8_t OccupancyValueOfCell(std::uint8_t cell);

}  // namespace enfilade::grid

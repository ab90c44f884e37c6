// SPDX-License-Identifier: Apache-2.0
#include "core/grid/occupancy_values.h"

#include <cmath>

#include "core/base/error.h"

namespace enfilade::grid {
namespace {

constexpr std::int8_t kFree = 0;
constexpr std::int8_t kOccupied = 100;

std::int8_t Nav2Value(const GreyInterpretation& by, int grey, std::optional<int> alpha) {
  if (by.mode == MapMode::kRaw) return grey <= kOccupied ? static_cast<std::int8_t>(grey) : kUnknownValue;
  if (alpha.value_or(kOpaqueAlpha) < kOpaqueAlpha) return kUnknownValue;
  const auto occupied_thresh = static_cast<float>(by.occupied_thresh);
  const auto free_thresh = static_cast<float>(by.free_thresh);
  const float shade = static_cast<float>(grey) / 255.0F;
  const float p = by.negate ? shade : 1.0F - shade;
  if (p <= free_thresh) return kFree;
  if (p >= occupied_thresh) return kOccupied;
  if (by.mode == MapMode::kTrinary) return kUnknownValue;
  return static_cast<std::int8_t>(std::round((p - free_thresh) / (occupied_thresh - free_thresh) * 100.0F));
}

std::int8_t Ros1Value(const GreyInterpretation& by, int grey, std::optional<int> alpha) {
  double mean = grey;
  if (by.mode == MapMode::kTrinary && alpha.has_value()) mean = (3.0 * grey + *alpha) / 4.0;
  if (by.negate) mean = 255.0 - mean;
  if (by.mode == MapMode::kRaw) return mean <= kOccupied ? static_cast<std::int8_t>(mean) : kUnknownValue;
  const double p = (255.0 - mean) / 255.0;
  if (p > by.occupied_thresh) return kOccupied;
  if (p < by.free_thresh) return kFree;
  if (by.mode == MapMode::kTrinary || alpha.value_or(kOpaqueAlpha) == 0) return kUnknownValue;
  // Equal thresholds leave only this value in between.
  const double range = by.occupied_thresh - by.free_thresh;
  return static_cast<std::int8_t>(range > 0.0 ? 1.0 + 98.0 * (p - by.free_thresh) / range : 1.0);
}

}  // namespace

std::int8_t LoadedValue(const GreyInterpretation& interpretation, int grey, std::optional<int> alpha) {
  return interpretation.dialect == MapDialect::kNav2 ? Nav2Value(interpretation, grey, alpha)
                                                     : Ros1Value(interpretation, grey, alpha);
}

std::array<std::int8_t, 256> LoadedValues(const GreyInterpretation& interpretation, int max_value) {
  std::array<std::int8_t, 256> values{};
  for (int level = 0; level < 256; ++level) {
    const int grey = level >= max_value ? 255 : (2 * level * 255 + max_value) / (2 * max_value);
    values[static_cast<std::size_t>(level)] = LoadedValue(interpretation, grey);
  }
  return values;
}

absl::Status GreySaveOptions::Validate() const {
  if (!(free_thresh >= 0.0 && free_thresh < occupied_thresh && occupied_thresh <= 1.0)) {
    return InvalidArgument("free_thresh is {} and occupied_thresh {}: expected 0 <= free_thresh < occupied_thresh <= 1",
                           free_thresh, occupied_thresh);
  }
  return absl::OkStatus();
}

GreyAlpha SavedGrey(const GreySaveOptions& options, std::int8_t value) {
  const bool is_known = value >= kFree && value <= kOccupied;
  switch (options.mode) {
    case MapMode::kRaw:
      return {.grey = is_known ? static_cast<std::uint8_t>(value) : std::uint8_t{255}};
    case MapMode::kScale:
      if (!is_known) return {.grey = 128, .alpha = 0};
      return {.grey = static_cast<std::uint8_t>(std::lround((100.0 - value) / 100.0 * 255.0))};
    case MapMode::kTrinary:
      break;
  }
  if (is_known && value <= std::lrint(options.free_thresh * 100.0)) return {.grey = 254};
  if (is_known && value >= std::lrint(options.occupied_thresh * 100.0)) return {.grey = 0};
  return {.grey = 205};
}

GreyInterpretation InterpretationOfSaved(const GreySaveOptions& options) {
  GreyInterpretation interpretation;
  interpretation.mode = options.mode;
  if (options.mode != MapMode::kTrinary) {
    interpretation.occupied_thresh = options.occupied_thresh;
    interpretation.free_thresh = options.free_thresh;
  }
  return interpretation;
}

std::uint8_t CellFromOccupancyValue(std::int8_t value) {
  return value < kFree || value > kOccupied ? kUnknownCell : CellFromProbability(value / 100.0);
}

std::int8_t OccupancyValueOfCell(std::uint8_t cell) {
  return cell == kUnknownCell ? kUnknownValue : static_cast<std::int8_t>(std::lround(ProbabilityOfCell(cell) * 100.0));
}

}  // namespace enfilade::grid

// SPDX-License-Identifier: Apache-2.0
// Pictures of plans, and what is known of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/files/rgb_image.h"
#include "perception/plan/read_plan.h"
#include "tests/support/plans/plan_scores.h"

namespace enfilade::bench {

// A level of a building.yaml of Open-RMF, whose vertices are pixels of the level's own picture.
struct PicturedLevel {
  std::string name;  // "hotel L1"
  std::filesystem::path picture;
  prior::PlanGraph truth;  // pixels of the picture, with metres per pixel
};

// Of all *.building.yaml in a folder, those levels that have a PNG beside the file.
absl::StatusOr<std::vector<PicturedLevel>> FindPicturedLevels(const std::filesystem::path& folder);

// The share of a plan's walls that their picture shows: samples with something dark within the tolerance. The rest is
// not to be found there by anything.
double ShareDrawn(const prior::PlanGraph& plan, const perception::GreyFrame& picture,
                  const testing::PlanTolerance& tolerance);

// What was read over the picture: true walls green, walls that are none red, walls that were not found blue. Doors:
// thin lines of the same colours.
grid::RgbImage DrawDifferences(const perception::PlanFile& found, const prior::PlanGraph& truth,
                               const testing::PlanTolerance& tolerance);

// The share of the length of all lines of a picture, as thinned before any is left out, that lie on walls.
absl::StatusOr<double> ShareOfStrokes(const std::string& bytes, const prior::PlanGraph& plan);

}  // namespace enfilade::bench

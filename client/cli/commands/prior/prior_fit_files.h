// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/correction/correct_plan.h"

namespace enfilade::cli {

// Lines of numbers with commas between them; empty lines and those that begin with # are left out. INVALID_ARGUMENT:
// naming the line.
absl::StatusOr<std::vector<prior::ControlPair>> ReadPairs(const std::filesystem::path& path);
absl::StatusOr<std::vector<Eigen::Vector2d>> ReadSheetPoints(const std::filesystem::path& path);

// plan_x_px,plan_y_px,input_x_m,input_y_m,sigma_m,state
std::string WriteLocatedPoints(const std::vector<Eigen::Vector2d>& points, const prior::PlanGraph& plan,
                               const prior::CorrectedPlan& corrected);
}  // namespace enfilade::cli

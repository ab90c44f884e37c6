// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "enfilade/v1/prior_map_service.pb.h"
#include "perception/plan/read_plan.h"

namespace enfilade::cli {

// PLAN and how to read it, for every command that reads one.
struct PlanOptions {
  std::string path;
  std::string measure;  // "X1,Y1,X2,Y2=M"
  int page = 0;
  std::vector<std::string> layers;
  std::string level;
};

// `level_option`: the name of the option for the level of a building.yaml.
void AddPlanOptions(CLI::App& command, PlanOptions& options, const std::string& level_option = "--level");

// INVALID_ARGUMENT, naming the option.
absl::StatusOr<perception::ReadPlanOptions> ToReadOptions(const PlanOptions& options);
absl::StatusOr<perception::PlanMeasure> ParseMeasure(const std::string& text);  // of --measure

v1::PlanMeasure MeasureToProto(const perception::PlanMeasure& measure);

}  // namespace enfilade::cli

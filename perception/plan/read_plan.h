// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"
#include "perception/image/frame.h"
#include "perception/plan/plan_picture.h"

namespace enfilade::perception {

struct ReadPlanOptions {
  int page = 0;                                       // of a PDF, from 1; 0: the only one
  std::vector<std::string> layers = {};               // of SVG and DXF: patterns with * and ?; empty: all
  std::string level = {};                             // of a building.yaml; empty: the lowest
  std::optional<PlanMeasure> measure = std::nullopt;  // wins over the file's own scale
};

struct PlanFile {
  prior::PlanGraph graph;
  std::vector<std::string> warnings;
  std::optional<GreyFrame> picture = std::nullopt;  // the sheet, if it is a picture; of a photo, the page rectified
};

// The walls of a floor plan (docs/prior_maps.md), planar, with the rooms between them. By its content the file is a
// picture (PNG, JPEG, PGM, a page of a PDF: walls are recognised), SVG, DXF, GeoJSON, or a building.yaml of Open-RMF.
// INVALID_ARGUMENT: another kind of file, a damaged one, one in which fewer than 8 walls are found; RESOURCE_EXHAUSTED:
// more than 1e6; FAILED_PRECONDITION: a PDF, and poppler-utils is not installed. Messages begin with the path.
absl::StatusOr<PlanFile> ReadPlanFile(const std::filesystem::path& path, const ReadPlanOptions& options = {});
absl::StatusOr<prior::PlanGraph> ReadPlan(const std::filesystem::path& path, const ReadPlanOptions& options = {});

// The same for bytes at hand.
absl::StatusOr<PlanFile> DecodePlan(std::string_view bytes, const ReadPlanOptions& options = {});

}  // namespace enfilade::perception

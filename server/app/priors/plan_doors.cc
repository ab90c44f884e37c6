// SPDX-License-Identifier: Apache-2.0
#include "server/app/priors/plan_doors.h"

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "nlohmann/json.hpp"

namespace enfilade::server {

absl::StatusOr<CorrectedDoors> ParseCorrectedDoors(const std::string& bytes) {
  const nlohmann::json document = nlohmann::json::parse(bytes, nullptr, /*allow_exceptions=*/false);
  CorrectedDoors doors;
  try {
    for (const nlohmann::json& feature : document.at("features")) {
      const nlohmann::json& properties = feature.at("properties");
      const std::string kind = properties.at("kind");
      if (kind != "wall" && kind != "door") continue;
      const auto ends = feature.at("geometry").at("coordinates").get<std::vector<std::vector<double>>>();
      const Eigen::Vector2d from(ends.at(0).at(0), ends.at(0).at(1)), to(ends.at(1).at(0), ends.at(1).at(1));
      const std::string state = properties.at("state");
      if (kind == "wall") {
        if (state != "contradicted") doors.plan.walls.emplace_back(from, to);
        continue;
      }
      const Eigen::Vector2d through(from.y() - to.y(), to.x() - from.x());
      const Eigen::Vector2d middle = 0.5 * (from + to);
      doors.plan.doors.push_back({.T_plan_door = {middle.x(), middle.y(), std::atan2(through.y(), through.x())},
                                  .width = (to - from).norm(),
                                  .sigma = properties.at("sigma_m")});
      doors.seen.push_back(state == "seen");
    }
  } catch (const std::exception& error) {
    return DataLoss("walls.geojson is damaged: {}", error.what());
  }
  return doors;
}

absl::StatusOr<closure::PlanWithDoors> ReadPlanDoors(const storage::CallContext& context,
                                                     const storage::PriorMapStore& prior_maps,
                                                     const storage::BlobStore& blobs, const SiteId& site,
                                                     const PriorMapId& id, const graph::PlanTies& ties) {
  ENFILADE_ASSIGN_OR_RETURN(const auto files, prior_maps.ListFiles(context, site, id));
  for (const storage::PriorMapFile& file : files) {
    if (file.product != storage::PriorMapProduct::kCorrected || file.name != kCorrectedWalls) continue;
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, blobs.Get(context, site, file.sha256));
    ENFILADE_ASSIGN_OR_RETURN(CorrectedDoors doors, ParseCorrectedDoors(bytes));
    doors.plan.maps = ties.maps;
    return std::move(doors.plan);
  }
  return closure::PlanWithDoors();
}

}  // namespace enfilade::server

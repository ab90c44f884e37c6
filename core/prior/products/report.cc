// SPDX-License-Identifier: Apache-2.0
#include "core/prior/products/report.h"

#include <algorithm>
#include <cmath>

#include "core/prior/products/products.h"
#include "nlohmann/json.hpp"

namespace enfilade::prior {
namespace {

using nlohmann::json;

json Ends(const Eigen::Vector2d& from, const Eigen::Vector2d& to) { return {{from.x(), from.y()}, {to.x(), to.y()}}; }

// The value below which `share` of them lie; null without any.
json Quantile(std::vector<double> values, double share) {
  if (values.empty()) return nullptr;
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index), values.end());
  return values[index];
}

json Spread(const std::vector<double>& values) {
  return {{"median", Quantile(values, 0.5)}, {"p95", Quantile(values, 0.95)}, {"most", Quantile(values, 1.0)}};
}

class Report {
 public:
  Report(const PlanGraph& plan, const PlanFit& fit) : plan_(plan), fit_(fit), corrected_(*fit.corrected) {}

  json Whole() const {
    const PlanTransform& T_map_sheet = fit_.alignment.T_map_sheet;
    const Eigen::Vector2d x = T_map_sheet.linear.col(0);
    return {{"model", NameOf(fit_.alignment.model)},
            {"mirrored", T_map_sheet.mirrored()},
            {"rotation_rad", std::atan2(x.y(), x.x())},
            {"scale_x", x.norm()},
            {"scale_y", T_map_sheet.linear.col(1).norm()},
            {"explained", corrected_.agreement().explained},
            {"contradicted", corrected_.agreement().contradicted()},
            {"rival_ratio", fit_.alignment.rival_ratio}};
  }

  json Walls() const {
    json walls;
    for (const Sight sight : {Sight::kSeen, Sight::kUnseen, Sight::kContradicted}) {
      int count = 0;
      double length = 0;
      for (std::size_t i = 0; i < plan_.walls.size(); ++i) {
        if (corrected_.walls()[i].sight != sight) continue;
        ++count;
        length += (End(plan_.walls[i].to) - End(plan_.walls[i].from)).norm();
      }
      walls[std::string(NameOf(sight))] = {{"count", count}, {"length_m", length}};
    }
    double length = 0;
    for (const AddedWall& wall : fit_.added) length += (wall.to - wall.from).norm();
    walls["added"] = {{"count", fit_.added.size()}, {"length_m", length}};
    return walls;
  }

  json Doors() const {
    json doors = {{"seen", 0}, {"unseen", 0}, {"contradicted", 0}};
    for (const PlanDoor& door : plan_.doors) {
      json& count = doors[std::string(NameOf(corrected_.Locate(0.5 * (door.from + door.to)).sight))];
      count = count.get<int>() + 1;
    }
    return doors;
  }

  json Corners() const {
    std::vector<char> is_seen(plan_.corners.size(), 0);
    for (std::size_t i = 0; i < plan_.walls.size(); ++i) {
      if (corrected_.walls()[i].sight != Sight::kSeen) continue;
      is_seen[static_cast<std::size_t>(plan_.walls[i].from)] = 1;
      is_seen[static_cast<std::size_t>(plan_.walls[i].to)] = 1;
    }
    json corners;
    for (const bool seen : {true, false}) {
      std::vector<double> moved, sigma;
      for (std::size_t i = 0; i < plan_.corners.size(); ++i) {
        if ((is_seen[i] != 0) != seen) continue;
        const CorrectedCorner& corner = corrected_.corners()[i];
        moved.push_back((corner.point - fit_.alignment.T_map_sheet(plan_.corners[i].point)).norm());
        sigma.push_back(std::sqrt(std::max(0.0, corner.covariance.trace() / 2)));
      }
      corners[seen ? "seen" : "unseen"] = {
          {"count", moved.size()}, {"moved_m", Spread(moved)}, {"sigma_m", Spread(sigma)}};
    }
    return corners;
  }

  json Stretch() const {
    std::vector<double> stretch;
    for (const CorrectedWall& wall : corrected_.walls()) {
      if (wall.sight == Sight::kSeen) stretch.push_back(wall.stretch);
    }
    return {{"median", Quantile(stretch, 0.5)}, {"least", Quantile(stretch, 0.0)}, {"most", Quantile(stretch, 1.0)}};
  }

  json ToCheck() const {
    json walls = json::array();
    for (std::size_t i = 0; i < plan_.walls.size(); ++i) {
      if (corrected_.walls()[i].sight != Sight::kContradicted) continue;
      walls.push_back(
          {{"state", "contradicted"}, {"wall", i}, {"ends", Ends(End(plan_.walls[i].from), End(plan_.walls[i].to))}});
    }
    for (const AddedWall& wall : fit_.added) walls.push_back({{"state", "added"}, {"ends", Ends(wall.from, wall.to)}});
    return walls;
  }

 private:
  const Eigen::Vector2d& End(int corner) const { return corrected_.corners()[static_cast<std::size_t>(corner)].point; }

  const PlanGraph& plan_;
  const PlanFit& fit_;
  const CorrectedPlan& corrected_;
};

}  // namespace

std::string WriteReport(const PlanGraph& plan, const PlanFit& fit) {
  const Report report(plan, fit);
  json document = report.Whole();
  document["walls"] = report.Walls();
  document["doors"] = report.Doors();
  document["corners"] = report.Corners();
  document["stretch"] = report.Stretch();
  document["to_check"] = report.ToCheck();
  return document.dump(1) + "\n";
}

}  // namespace enfilade::prior

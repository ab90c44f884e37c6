// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/plan_ties.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::graph {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kVersionWithShafts = 2;

void Put(const Pose2& pose, BinaryWriter& writer) {
  for (const double value : {pose.x, pose.y, pose.yaw}) writer.Put(value);
}

Pose2 GetPose(BinaryReader& reader) {
  Pose2 pose;
  for (double* const value : {&pose.x, &pose.y, &pose.yaw}) *value = reader.Get<double>();
  return pose;
}

bool IsSigma(double value) { return std::isfinite(value) && value > 0.0; }

absl::Status Check(const PlanTies& ties) {
  const auto is_corner = [&](int corner) {
    return corner >= 0 && static_cast<std::size_t>(corner) < ties.corners.size();
  };
  for (const Eigen::Vector2d& corner : ties.corners) {
    if (!corner.allFinite()) return DataLoss("a corner of the plan is not finite");
  }
  for (const PlanStrut& strut : ties.struts) {
    if (is_corner(strut.from) && is_corner(strut.to) && strut.from != strut.to) continue;
    return DataLoss("a strut of the plan joins corners {} and {} of {}", strut.from, strut.to, ties.corners.size());
  }
  const auto is_before = [](const MapInPlan& a, const MapInPlan& b) { return a.map < b.map; };
  if (!std::is_sorted(ties.maps.begin(), ties.maps.end(), is_before))
    return DataLoss("the plan's maps are not in order");
  for (const MapInPlan& map : ties.maps) {
    if (!IsFinite(map.T_plan_map)) return DataLoss("the place of map {} in the plan is not finite", map.map.value());
  }
  for (const WallSighting& sighting : ties.sightings) {
    const bool is_strut = sighting.strut >= 0 && static_cast<std::size_t>(sighting.strut) < ties.struts.size();
    if (!is_strut || !ties.HasSeen(sighting.map) || !IsFinite(sighting.T_map_line) || !std::isfinite(sighting.along) ||
        !std::isfinite(sighting.length) || !IsSigma(sighting.across_sigma) || !IsSigma(sighting.yaw_sigma)) {
      return DataLoss("a wall that was seen in map \"{}\" is damaged", sighting.map.value());
    }
  }
  for (const ShaftInPlan& shaft : ties.shafts) {
    const bool is_outline = shaft.outline.size() >= 3 && shaft.held_by.size() == shaft.outline.size();
    if (shaft.name.empty() || !is_outline || !std::all_of(shaft.held_by.begin(), shaft.held_by.end(), is_corner) ||
        !std::all_of(shaft.outline.begin(), shaft.outline.end(),
                     [](const auto& corner) { return corner.allFinite(); })) {
      return DataLoss("shaft \"{}\" of the plan is damaged", shaft.name);
    }
  }
  if (!IsSigma(ties.corner_sigma) || !IsSigma(ties.stretch_sigma)) {
    return DataLoss("the plan's standard deviations {} and {} are not positive", ties.corner_sigma, ties.stretch_sigma);
  }
  return absl::OkStatus();
}

void Put(const Eigen::Vector2d& point, BinaryWriter& writer) {
  writer.Put(point.x());
  writer.Put(point.y());
}

Eigen::Vector2d GetPoint(BinaryReader& reader) {
  const auto x = reader.Get<double>();
  return {x, reader.Get<double>()};
}

void Put(const ShaftInPlan& shaft, BinaryWriter& writer) {
  writer.PutString(shaft.name);
  writer.Put(static_cast<std::uint8_t>(shaft.is_lift ? 1 : 0));
  writer.Put(static_cast<std::uint32_t>(shaft.outline.size()));
  for (std::size_t i = 0; i < shaft.outline.size(); ++i) {
    Put(shaft.outline[i], writer);
    writer.Put(static_cast<std::int32_t>(shaft.held_by[i]));
  }
}

ShaftInPlan GetShaft(BinaryReader& reader, bool& is_damaged) {
  ShaftInPlan shaft;
  shaft.name = std::string(reader.GetString());
  const auto kind = reader.Get<std::uint8_t>();
  shaft.is_lift = kind == 1;
  is_damaged |= kind > 1;
  for (auto count = reader.Get<std::uint32_t>(); count > 0 && reader.ok(); --count) {
    shaft.outline.push_back(GetPoint(reader));
    shaft.held_by.push_back(reader.Get<std::int32_t>());
  }
  return shaft;
}

}  // namespace

Eigen::Vector2d ShaftInPlan::middle() const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : outline) sum += corner;
  return sum / static_cast<double>(outline.size());
}

bool PlanTies::HasSeen(const MapId& map) const {
  const auto at = std::lower_bound(maps.begin(), maps.end(), map,
                                   [](const MapInPlan& one, const MapId& id) { return one.map < id; });
  return at != maps.end() && at->map == map;
}

void PlanTies::KeepMaps(const std::vector<MapId>& kept) {
  const auto is_dropped = [&](const auto& one) { return std::find(kept.begin(), kept.end(), one.map) == kept.end(); };
  std::erase_if(sightings, is_dropped);
  std::erase_if(maps, is_dropped);
}

std::string EncodePlanTies(const PlanTies& ties) {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put(ties.shafts.empty() ? kVersion : kVersionWithShafts);
  writer.Put(ties.corner_sigma);
  writer.Put(ties.stretch_sigma);
  writer.Put(static_cast<std::uint32_t>(ties.corners.size()));
  for (const Eigen::Vector2d& corner : ties.corners) Put(corner, writer);
  writer.Put(static_cast<std::uint32_t>(ties.struts.size()));
  for (const PlanStrut& strut : ties.struts) {
    for (const int value : {strut.from, strut.to, strut.wall}) writer.Put(static_cast<std::int32_t>(value));
  }
  writer.Put(static_cast<std::uint32_t>(ties.maps.size()));
  for (const MapInPlan& map : ties.maps) {
    writer.PutString(map.map.value());
    Put(map.T_plan_map, writer);
  }
  writer.Put(static_cast<std::uint32_t>(ties.sightings.size()));
  for (const WallSighting& sighting : ties.sightings) {
    writer.Put(static_cast<std::int32_t>(sighting.strut));
    writer.PutString(sighting.map.value());
    Put(sighting.T_map_line, writer);
    for (const double value : {sighting.along, sighting.length, sighting.across_sigma, sighting.yaw_sigma}) {
      writer.Put(value);
    }
  }
  if (ties.shafts.empty()) return bytes;
  writer.Put(static_cast<std::uint32_t>(ties.shafts.size()));
  for (const ShaftInPlan& shaft : ties.shafts) Put(shaft, writer);
  return bytes;
}

absl::StatusOr<PlanTies> DecodePlanTies(std::string_view bytes) {
  BinaryReader reader(bytes);
  const auto version = reader.Get<std::uint8_t>();
  if (version > kVersionWithShafts)
    return FailedPrecondition("the ties of a plan have format {}, which is newer", version);
  PlanTies ties;
  ties.corner_sigma = reader.Get<double>();
  ties.stretch_sigma = reader.Get<double>();
  for (auto count = reader.Get<std::uint32_t>(); count > 0 && reader.ok(); --count) {
    ties.corners.push_back(GetPoint(reader));
  }
  for (auto count = reader.Get<std::uint32_t>(); count > 0 && reader.ok(); --count) {
    PlanStrut& strut = ties.struts.emplace_back();
    for (int* const value : {&strut.from, &strut.to, &strut.wall}) *value = reader.Get<std::int32_t>();
  }
  for (auto count = reader.Get<std::uint32_t>(); count > 0 && reader.ok(); --count) {
    MapInPlan& map = ties.maps.emplace_back();
    map.map = MapId(std::string(reader.GetString()));
    map.T_plan_map = GetPose(reader);
  }
  for (auto count = reader.Get<std::uint32_t>(); count > 0 && reader.ok(); --count) {
    WallSighting& sighting = ties.sightings.emplace_back();
    sighting.strut = reader.Get<std::int32_t>();
    sighting.map = MapId(std::string(reader.GetString()));
    sighting.T_map_line = GetPose(reader);
    for (double* const value : {&sighting.along, &sighting.length, &sighting.across_sigma, &sighting.yaw_sigma}) {
      *value = reader.Get<double>();
    }
  }
  bool is_damaged = version < kVersion;
  if (version == kVersionWithShafts) {
    for (auto count = reader.Get<std::uint32_t>(); count > 0 && reader.ok(); --count) {
      ties.shafts.push_back(GetShaft(reader, is_damaged));
    }
    is_damaged |= ties.shafts.empty();
  }
  if (is_damaged || !reader.at_end()) return DataLoss("the ties of a plan are damaged");
  ENFILADE_RETURN_IF_ERROR(Check(ties));
  return ties;
}

}  // namespace enfilade::graph

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"
#include "client/simulator/sensors/sensors.h"
#include "client/simulator/world/world.h"
#include "core/base/noise.h"
#include "core/geometry/pose2.h"
#include "core/localization/localize.h"

namespace enfilade::bench {

// A simulated building, and its map as a robot made it.
struct Building {
  std::shared_ptr<const simulator::World> world;
  std::string level;
  std::shared_ptr<const localization::SearchableMap> map;
  Pose2 T_campus_map;
  std::set<std::string> entered;  // areas
};

// Drives the campus's first robot through it and maps the drive as one map.
absl::StatusOr<Building> MapBuilding(simulator::Campus campus, std::uint64_t seed);

// A random place on ground that the map has as free, in an area that was entered (`known`), or in one that was not.
// Unset if there is none.
std::optional<Pose2> FindPlace(const Building& building, bool known, Noise& noise);

// A drive of about `length` (m) over clear ground: straight on, or with the smallest turn after which the way is free.
std::vector<Pose2> PlanDrive(const Building& building, const Pose2& start, double length, Noise& noise);

// What a robot recorded that is to be located.
struct QueryDrive {
  std::vector<localization::QueryScan> scans;
  Pose2 T_map_robot;  // the truth at the last scan
};

// What the robot records on the way: scans, and odometry whose wheels' sizes are wrong and which slip.
QueryDrive Record(const Building& building, const std::vector<Pose2>& drive, const simulator::ScannerOptions& scanner,
                  std::uint64_t seed);

// A recorded log mapped as one map, with queries: scans that did not become part of the map (they are no keyframes),
// `count` at most, evenly chosen, each with the scans of the `length` metres before it. The truth is the mapper's pose.
struct MappedLog {
  std::shared_ptr<const localization::SearchableMap> map;
  std::vector<QueryDrive> queries;
};
absl::StatusOr<MappedLog> MapLog(const std::string& path, int count, double length);

}  // namespace enfilade::bench

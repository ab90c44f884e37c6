// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/drive_truth.h"

#include <algorithm>
#include <stdexcept>

#include "tests/e2e/campus/json_lines.h"

namespace enfilade::testing {

DriveTruth ReadTruth(const std::string& robot, const std::filesystem::path& file) {
  DriveTruth truth;
  truth.robot = robot;
  for (const nlohmann::json& line : ReadJsonLines(file)) {
    const TimeNs time = line.at("time_ns");
    const Pose2 pose = PoseOf(line.at("pose"));
    if (line.at("type") == "pose") truth.poses.push_back({time, pose, line.at("level"), line.at("area")});
    if (line.at("type") == "passage") {
      truth.passages.push_back({time, pose, line.at("level"), line.at("door"), line.at("from"), line.at("to")});
    }
  }
  if (truth.poses.empty()) throw std::runtime_error(file.string() + " has no poses");
  return truth;
}

Pose2 TruthAt(const DriveTruth& truth, TimeNs time) {
  const auto after = std::lower_bound(truth.poses.begin(), truth.poses.end(), time,
                                      [](const TruePoint& point, TimeNs at) { return point.time < at; });
  if (after == truth.poses.begin()) return after->T_campus_robot;
  if (after == truth.poses.end()) return truth.poses.back().T_campus_robot;
  const auto before = std::prev(after);
  const double t = static_cast<double>(time - before->time) / static_cast<double>(after->time - before->time);
  return Interpolate(before->T_campus_robot, after->T_campus_robot, t);
}

std::vector<TrueDoor> DoorsOf(const simulator::Campus& campus) {
  std::vector<TrueDoor> doors;
  for (const simulator::Door& door : campus.doors) {
    if (!door.opening) doors.push_back({door.id, door.a, door.b});
  }
  return doors;
}

}  // namespace enfilade::testing

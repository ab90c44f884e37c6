// SPDX-License-Identifier: Apache-2.0
#include "core/survey/level_survey.h"

#include <algorithm>
#include <cmath>

namespace enfilade::survey {

const SurveyedMap* LevelSurvey::FindMap(const MapId& id) const {
  const auto found = std::find_if(maps.begin(), maps.end(), [&](const SurveyedMap& map) { return map.id == id; });
  return found == maps.end() ? nullptr : &*found;
}

std::optional<Pose2> PlaceOf(const SurveyedSession& session) {
  if (session.visits.empty()) return std::nullopt;
  const auto count = static_cast<double>(session.visits.size());
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  for (const Visit& visit : session.visits) {
    from += visit.T_map_robot.translation() / count;
    to += visit.T_level_robot.translation() / count;
  }
  // Positions and headings both show the rotation; a heading counts as much as a position 1 m from the centre.
  double sine = 0.0;
  double cosine = 0.0;
  for (const Visit& visit : session.visits) {
    const Eigen::Vector2d a = visit.T_map_robot.translation() - from;
    const Eigen::Vector2d b = visit.T_level_robot.translation() - to;
    const double turn = visit.T_level_robot.yaw - visit.T_map_robot.yaw;
    sine += a.x() * b.y() - a.y() * b.x() + std::sin(turn);
    cosine += a.dot(b) + std::cos(turn);
  }
  const Pose2 turned{0.0, 0.0, std::atan2(sine, cosine)};
  const Eigen::Vector2d translation = to - turned * from;
  return Pose2{translation.x(), translation.y(), turned.yaw};
}

}  // namespace enfilade::survey

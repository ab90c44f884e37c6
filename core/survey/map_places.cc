// SPDX-License-Identifier: Apache-2.0
#include "core/survey/map_places.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace enfilade::survey {
namespace {

struct PlacedSession {
  Pose2 T_level_map = {};
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // of its drive, m in the map's frame
  double length = 0.0;                               // m, of its drive
};

double LengthOf(const SurveyedSession& session) {
  double length = 1e-6;
  for (std::size_t i = 1; i < session.visits.size(); ++i) {
    length += Between(session.visits[i - 1].T_map_robot, session.visits[i].T_map_robot).translation().norm();
  }
  return length;
}

Eigen::Vector2d MiddleOf(const SurveyedSession& session) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Visit& visit : session.visits) middle += visit.T_map_robot.translation();
  return middle / static_cast<double>(session.visits.size());
}

// Unset without visits.
std::optional<PlacedSession> Placed(const SurveyedSession& session) {
  const std::optional<Pose2> place = PlaceOf(session);
  if (!place) return std::nullopt;
  return PlacedSession{*place, MiddleOf(session), LengthOf(session)};
}

bool AgreesWith(const Pose2& T_level_map, const PlacedSession& placed, const SurveyOptions& options) {
  return (T_level_map * placed.middle - placed.T_level_map * placed.middle).norm() <= options.apart &&
         std::abs(Between(T_level_map, placed.T_level_map).yaw) <= options.turned;
}

// Of the longest session among those that agree with most of what was driven in the map.
Pose2 PlaceOfMap(const std::vector<PlacedSession>& sessions, const SurveyOptions& options) {
  const PlacedSession* best = nullptr;
  double most = 0.0;
  for (const PlacedSession& one : sessions) {
    double agreeing = 0.0;
    for (const PlacedSession& other : sessions) {
      if (AgreesWith(one.T_level_map, other, options)) agreeing += other.length;
    }
    if (best != nullptr && (agreeing < most || (agreeing == most && one.length <= best->length))) continue;
    most = agreeing;
    best = &one;
  }
  return best->T_level_map;
}

}  // namespace

std::map<MapId, Pose2> PlaceMaps(const LevelSurvey& survey, const SurveyOptions& options) {
  std::map<MapId, std::vector<PlacedSession>> sessions;
  for (const Drive& drive : survey.drives) {
    for (const SurveyedSession& session : drive) {
      if (const std::optional<PlacedSession> placed = Placed(session)) sessions[session.map].push_back(*placed);
    }
  }
  std::map<MapId, Pose2> places;
  for (const auto& [map, placed] : sessions) places[map] = PlaceOfMap(placed, options);
  return places;
}

bool IsOutOfPlace(const SurveyedSession& session, const Pose2& T_level_map, const SurveyOptions& options) {
  const std::optional<PlacedSession> placed = Placed(session);
  return placed && !AgreesWith(T_level_map, *placed, options);
}

}  // namespace enfilade::survey

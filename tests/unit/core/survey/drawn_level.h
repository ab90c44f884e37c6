// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/rearrange/rearrangement.h"
#include "core/survey/arrange_maps.h"
#include "core/survey/drive_rooms.h"

namespace enfilade::survey {

// Rooms as text: a digit is a cell of the room with that label, anything else is none. The first row is the top. Cells
// have 0.5 m; the lower left corner is the origin.
inline rooms::RoomPartition DrawRooms(const std::vector<std::string>& rows, std::vector<rooms::Door> doors) {
  rooms::RoomPartition partition;
  partition.geometry = {0.5, {}, static_cast<int>(rows[0].size()), static_cast<int>(rows.size())};
  partition.labels.resize(partition.geometry.cell_count());
  int count = 0;
  for (int row = 0; row < partition.geometry.height; ++row) {
    const std::string& text = rows[rows.size() - 1 - static_cast<std::size_t>(row)];
    for (int column = 0; column < partition.geometry.width; ++column) {
      const char c = text[static_cast<std::size_t>(column)];
      if (c < '1' || c > '9') continue;
      partition.labels[partition.geometry.index(column, row)] = static_cast<std::uint16_t>(c - '0');
      count = std::max(count, c - '0');
    }
  }
  for (int i = 1; i <= count; ++i) partition.rooms.push_back({.id = i});
  partition.doors = std::move(doors);
  return partition;
}

// A corridor (1) with a room to its south (2) and one to its north (3):
//   y 5.5 .. 7.5  room 3, x 3 .. 6, door at x 4.5 to 5.5
//   y 3 .. 5      the corridor, x 0 .. 10
//   y 0 .. 2.5    room 2, x 0 .. 4, door at x 1 to 2
inline rooms::RoomPartition Corridor() {
  return DrawRooms(
      {
          "......333333........",  // y 7.0
          "......333333........",  // 6.5
          "......333333........",  // 6.0
          "......333333........",  // 5.5
          "...................." /* wall, y 5.0 */,
          "11111111111111111111",  // 4.5
          "11111111111111111111",  // 4.0
          "11111111111111111111",  // 3.5
          "11111111111111111111",  // 3.0
          "....................",  // 2.5
          "22222222............",  // 2.0
          "22222222............",  // 1.5
          "22222222............",  // 1.0
          "22222222............",  // 0.5
          "22222222............",  // 0.0
      },
      {{{1.0, 2.75}, {2.0, 2.75}, {1, 2}}, {{4.5, 5.25}, {5.5, 5.25}, {1, 3}}});
}

// A drive along waypoints, a visit every quarter metre, cut into sessions: each leg is one.
struct Leg {
  std::string session;
  std::string map;
  Pose2 T_level_map = {};
  std::vector<Eigen::Vector2d> points;
  std::optional<TimeNs> left = std::nullopt;
};

inline Drive MakeDrive(const std::vector<Leg>& legs) {
  Drive drive;
  TimeNs time = 0;
  for (const Leg& leg : legs) {
    SurveyedSession session{.id = SessionId(leg.session), .map = MapId(leg.map), .left = leg.left};
    for (std::size_t i = 0; i + 1 < leg.points.size() || (i == 0 && leg.points.size() == 1); ++i) {
      const Eigen::Vector2d from = leg.points[i];
      const Eigen::Vector2d way =
          leg.points.size() > 1 ? Eigen::Vector2d(leg.points[i + 1] - from) : Eigen::Vector2d(0.0, 0.0);
      const int steps = std::max(1, static_cast<int>(way.norm() / 0.25));
      for (int k = 0; k < steps; ++k) {
        const Eigen::Vector2d p = from + way * k / steps;
        const Pose2 T_level_robot{p.x(), p.y(), std::atan2(way.y(), way.x())};
        time += 500'000'000;
        session.visits.push_back({static_cast<std::int64_t>(session.visits.size()) * 5 + 1, time,
                                  Between(leg.T_level_map, T_level_robot), T_level_robot});
      }
    }
    drive.push_back(std::move(session));
  }
  return drive;
}

inline std::function<std::string()> NumberedIds() {
  return [n = 0]() mutable { return "new-" + std::to_string(++n); };
}

// The survey after the rearrangement, as the next survey would see it.
inline LevelSurvey After(const LevelSurvey& before, const rearrange::Rearrangement& change) {
  LevelSurvey after = before;
  for (const rearrange::MapSeed& seed : change.new_maps) {
    after.maps.push_back({.id = seed.id, .environment = seed.environment, .slam_profile = seed.slam_profile});
  }
  std::vector<rearrange::SessionCut> cuts = change.cuts;  // the last one of each session first
  std::sort(cuts.begin(), cuts.end(), [](const auto& a, const auto& b) { return a.first_sequence > b.first_sequence; });
  for (const rearrange::SessionCut& cut : cuts) {
    for (Drive& drive : after.drives) {
      for (std::size_t i = 0; i < drive.size(); ++i) {
        if (drive[i].id != cut.session) continue;
        SurveyedSession rest = drive[i];
        rest.id = cut.rest;
        rest.T_map_entry.reset();
        std::erase_if(rest.visits, [&](const Visit& visit) { return visit.sequence < cut.first_sequence; });
        std::erase_if(drive[i].visits, [&](const Visit& visit) { return visit.sequence >= cut.first_sequence; });
        drive[i].left.reset();
        drive.insert(drive.begin() + static_cast<std::ptrdiff_t>(i) + 1, std::move(rest));
        break;
      }
    }
  }
  for (const rearrange::SessionMove& move : change.moves) {
    for (Drive& drive : after.drives) {
      for (SurveyedSession& session : drive) {
        if (session.id != move.session) continue;
        session.map = move.to;
        for (Visit& visit : session.visits) visit.T_map_robot = move.T_to_from * visit.T_map_robot;
      }
    }
  }
  for (const LinkPointId& id : change.removed_link_points) {
    std::erase_if(after.link_points, [&](const graph::LinkPoint& one) { return one.id == id; });
  }
  for (const graph::LinkPoint& link_point : change.link_points) {
    std::erase_if(after.link_points, [&](const graph::LinkPoint& one) { return one.id == link_point.id; });
    after.link_points.push_back(link_point);
  }
  for (const rearrange::MapRedirect& redirect : change.redirects) {
    std::erase_if(after.maps, [&](const SurveyedMap& map) { return map.id == redirect.from; });
  }
  return after;
}

// Which map each room's visits are in.
inline std::map<int, std::set<std::string>> MapsOfRooms(const LevelSurvey& survey,
                                                        const rooms::RoomPartition& partition) {
  std::map<int, std::set<std::string>> maps;
  for (const Stretch& stretch : FindRooms(survey, partition, {}).stretches) {
    maps[stretch.room].insert(survey.drives[stretch.drive][stretch.session].map.value());
  }
  return maps;
}

// The rooms that link points join, as pairs of maps.
inline std::multiset<std::set<std::string>> JoinedMaps(const LevelSurvey& survey) {
  std::multiset<std::set<std::string>> joined;
  for (const graph::LinkPoint& link_point : survey.link_points) {
    if (link_point.is_candidate()) continue;
    std::set<std::string> maps;
    for (const graph::Anchor& anchor : link_point.anchors) maps.insert(anchor.map.value());
    joined.insert(maps);
  }
  return joined;
}

inline graph::LinkPoint Join(const std::string& id, const graph::Anchor& a, const graph::Anchor& b) {
  graph::LinkPoint link_point;
  link_point.id = LinkPointId(id);
  link_point.anchors = {a, b};
  link_point.direction = b.map;
  return link_point;
}

inline graph::Anchor AnchorAt(const std::string& map, const Pose2& T_level_map, const Pose2& T_level_place) {
  const Eigen::Vector3d sigmas(0.022, 0.022, 0.0072);  // about those of a survey
  return {MapId(map), Between(T_level_map, T_level_place), sigmas.cwiseAbs2().asDiagonal()};
}

inline rearrange::Rearrangement Arrange(const LevelSurvey& survey) {
  return ArrangeMaps(survey, Corridor(), {}, NumberedIds());
}

inline constexpr Pose2 kPlaceB{5.0, 4.0, 1.0};

// The corridor has two maps: a robot was in it, left it through the south door and came back, and the server did not
// recognise it.
inline LevelSurvey DoubledCorridor() {
  LevelSurvey survey;
  std::vector<Leg> legs = {{"s1", "a", {}, {{9.0, 4.0}, {1.5, 4.0}, {1.5, 2.0}}},
                           {"s2", "b", {1.0, 1.0, 0.3}, {{1.5, 2.0}, {3.0, 1.0}, {1.5, 1.0}, {1.5, 3.5}}},
                           {"s3", "c", kPlaceB, {{1.5, 3.5}, {4.0, 4.0}}}};
  survey.drives = {MakeDrive(legs)};
  Drive& drive = survey.drives[0];
  for (const std::size_t i : {0, 1}) {  // the passages' times: the visit nearest to y 2.75
    for (const Visit& visit : drive[i].visits) {
      const bool behind = i == 0 ? visit.T_level_robot.y < 2.75 : visit.T_level_robot.y > 2.75;
      if (behind && !drive[i].left) drive[i].left = visit.time;
    }
  }
  survey.maps = {{.id = MapId("a"), .root = true}, {.id = MapId("b")}, {.id = MapId("c")}};
  const Pose2 door{1.5, 2.75, -M_PI / 2};
  survey.link_points = {Join("d1", AnchorAt("a", {}, door), AnchorAt("b", {1.0, 1.0, 0.3}, door)),
                        Join("d2", AnchorAt("b", {1.0, 1.0, 0.3}, door), AnchorAt("c", kPlaceB, door))};
  return survey;
}

// A robot was in the corridor three times: s1 for 6 m, s2 for 4 m and s3 for 3 m. They are one map, in which s1 lies by
// `error` elsewhere than the others.
inline LevelSurvey CorridorDrivenThreeTimes(const Pose2& error) {
  LevelSurvey survey;
  survey.drives = {MakeDrive({{"s1", "a", error, {{1.0, 4.0}, {7.0, 4.0}}},
                              {"s2", "a", {}, {{7.0, 4.0}, {3.0, 4.0}}},
                              {"s3", "a", {}, {{3.0, 4.0}, {6.0, 4.0}}}})};
  survey.maps = {{.id = MapId("a"), .root = true}};
  return survey;
}

}  // namespace enfilade::survey

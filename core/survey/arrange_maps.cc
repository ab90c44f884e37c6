// SPDX-License-Identifier: Apache-2.0
#include "core/survey/arrange_maps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/survey/drive_rooms.h"
#include "core/survey/map_places.h"
#include "core/survey/map_plan.h"
#include "fmt/format.h"

namespace enfilade::survey {
namespace {

class MapArranger {
 public:
  MapArranger(const LevelSurvey& survey, const SurveyOptions& options, const std::function<std::string()>& new_id,
              RoomsOfDrives found)
      : survey_(survey), options_(options), new_id_(new_id), found_(std::move(found)) {}

  void Run(const rooms::RoomPartition& partition) {
    plan_.T_level_map = PlaceMaps(survey_, options_);
    for (const auto& [cabin, T_level_cabin] : survey_.cabin_places) {
      if (survey_.FindMap(cabin) != nullptr) plan_.T_level_map[cabin] = T_level_cabin;
    }
    ChooseMaps();
    ChooseCabins(partition);
    BeginMaps();
    MeasureExtents();
    MoveSessions();
    MoveRides(partition);
    PutRidesBegun();
    RedirectEmptyMaps();
    RedirectAwaitedMaps(partition);
  }

  const RoomsOfDrives& found() const { return found_; }
  const MapPlan& plan() const { return plan_; }
  rearrange::Rearrangement TakeResult() { return std::move(result_); }

 private:
  const SurveyedSession& SessionOf(const Stretch& stretch) const {
    return survey_.drives[stretch.drive][stretch.session];
  }

  void ChooseMaps() {
    for (const Stretch& stretch : found_.stretches) {
      driven_[{stretch.room, SessionOf(stretch).map}] += stretch.length + 1e-3;
    }
    // The root first, then busy maps, then those driven farthest in.
    std::vector<std::tuple<bool, bool, double, int, MapId>> choices;
    for (const auto& [pair, length] : driven_) {
      const SurveyedMap* map = survey_.FindMap(pair.second);
      choices.emplace_back(map == nullptr || !map->root, map == nullptr || !map->stays(), -length, pair.first,
                           pair.second);
    }
    std::sort(choices.begin(), choices.end());
    std::set<MapId> taken = ChoosePinnedMaps();
    for (const auto& [not_root, not_busy, length, room, map] : choices) {
      if (plan_.map_of_room.contains(room) || taken.contains(map)) continue;
      plan_.map_of_room[room] = map;
      taken.insert(map);
    }
  }

  // A pinned map may be that of several rooms: those that it was driven in farther than any other map, and those that
  // one of its sessions was in farther than a session goes on behind its door, before any session of other maps was.
  // What is recorded later and taken for the map by a wrong verdict claims no room. Returns the pinned maps.
  std::set<MapId> ChoosePinnedMaps() {
    std::set<MapId> pinned;
    std::map<int, double> farthest;         // m, by room
    std::map<int, double> farthest_pinned;  // m, by room
    for (const auto& [pair, length] : driven_) farthest[pair.first] = std::max(farthest[pair.first], length);
    const std::map<int, MapId> first = FirstMaps();
    for (const auto& [pair, length] : driven_) {
      const auto& [room, map] = pair;
      if (!IsPinned(map)) continue;
      pinned.insert(map);
      const auto found = first.find(room);
      const bool was_first = found != first.end() && found->second == map;
      if (!was_first && length < farthest[room]) continue;
      double& best = farthest_pinned[room];
      if (length <= best) continue;
      best = length;
      plan_.map_of_room[room] = map;
    }
    return pinned;
  }

  // The map of the session that was in each room first, and farther than a session goes on behind its door.
  std::map<int, MapId> FirstMaps() const {
    constexpr double kBehindDoor = 4.0;  // m
    std::map<int, std::pair<TimeNs, MapId>> first;
    for (const Stretch& stretch : found_.stretches) {
      const SurveyedSession& session = SessionOf(stretch);
      if (stretch.length < kBehindDoor) continue;
      const TimeNs time = session.visits[stretch.first].time;
      const auto [found, is_new] = first.try_emplace(stretch.room, time, session.map);
      if (!is_new && time < found->second.first) found->second = {time, session.map};
    }
    std::map<int, MapId> maps;
    for (const auto& [room, visit] : first) maps[room] = visit.second;
    return maps;
  }

  bool IsPinned(const MapId& map) const {
    const SurveyedMap* found = survey_.FindMap(map);
    return found != nullptr && found->pinned;
  }

  // The cabin of a lift is one map, of one level. The room behind a door that leads to it is that cabin.
  void ChooseCabins(const rooms::RoomPartition& partition) {
    for (const graph::LinkPoint& link_point : survey_.link_points) {
      if (link_point.use == graph::LinkPointUse::kSuspended) continue;
      for (const graph::Anchor& cabin : link_point.anchors) {
        if (!survey_.cabins.contains(cabin.map)) continue;
        for (const graph::Anchor& hall : link_point.anchors) ChooseCabin(partition, link_point, hall, cabin);
      }
    }
  }

  void ChooseCabin(const rooms::RoomPartition& partition, const graph::LinkPoint& link_point, const graph::Anchor& hall,
                   const graph::Anchor& cabin) {
    const auto T_level_hall = plan_.T_level_map.find(hall.map);
    if (survey_.cabins.contains(hall.map) || T_level_hall == plan_.T_level_map.end()) return;
    const Pose2 T_level_door = T_level_hall->second * hall.T_map_place;
    const int room = RoomOnSide(partition, link_point, cabin.map, T_level_door);
    if (room == 0 || room == RoomOnSide(partition, link_point, hall.map, T_level_door)) return;
    const auto now = plan_.map_of_room.find(room);
    if (now != plan_.map_of_room.end() && !MayGo(now->second)) return;
    plan_.map_of_room[room] = cabin.map;
    const auto measured = survey_.cabin_places.find(cabin.map);
    plan_.T_level_map[cabin.map] =
        measured != survey_.cabin_places.end() ? measured->second : T_level_door * Inverse(cabin.T_map_place);
  }

  bool MayGo(const MapId& map) const {
    const SurveyedMap* found = survey_.FindMap(map);
    return found != nullptr && !found->root && !found->busy && !found->pinned;
  }

  // A map for each room whose maps are all those of other rooms. Its frame is that of the session that was longest in
  // the room.
  void BeginMaps() {
    std::map<int, const Stretch*> longest;
    for (const Stretch& stretch : found_.stretches) {
      if (plan_.map_of_room.contains(stretch.room)) continue;
      const Stretch*& best = longest[stretch.room];
      if (best == nullptr || stretch.length > best->length) best = &stretch;
    }
    for (const auto& [room, stretch] : longest) {
      const SurveyedSession& session = SessionOf(*stretch);
      const SurveyedMap* model = survey_.FindMap(session.map);
      const std::optional<Pose2> place = PlaceOf(PartOf(session, stretch->first, stretch->last));
      if (model == nullptr || !place) continue;
      rearrange::MapSeed seed;
      seed.id = MapId(new_id_());
      seed.name_prefix = options_.map_name;
      seed.level = survey_.level;
      seed.environment = model->environment;
      seed.slam_profile = model->slam_profile;
      plan_.map_of_room[room] = seed.id;
      plan_.T_level_map[seed.id] = *place;
      AddReason(fmt::format("map {} covers several rooms: {:.0f} m of its drive get a map of their own",
                            session.map.value(), driven_.at({room, session.map})));
      result_.new_maps.push_back(std::move(seed));
    }
  }

  // How far robots went in each map as it will be.
  void MeasureExtents() {
    struct Sums {
      double count = 0.0;
      Eigen::Vector2d places = Eigen::Vector2d::Zero();
      double squares = 0.0;
    };
    std::map<MapId, Sums> sums;
    for (const Stretch& stretch : found_.stretches) {
      Sums& of_map = sums[MapOf(stretch)];
      const SurveyedSession& session = SessionOf(stretch);
      for (std::size_t i = stretch.first; i <= stretch.last; ++i) {
        const Eigen::Vector2d place = session.visits[i].T_level_robot.translation();
        of_map.count += 1.0;
        of_map.places += place;
        of_map.squares += place.squaredNorm();
      }
    }
    for (const auto& [map, of_map] : sums) {
      const double variance = of_map.squares / of_map.count - (of_map.places / of_map.count).squaredNorm();
      plan_.extents[map] = std::sqrt(std::max(variance, 0.0));
    }
  }

  void MoveSessions() {
    for (std::size_t i = 0; i < found_.stretches.size();) {
      std::size_t end = i;
      while (end < found_.stretches.size() && found_.stretches[end].drive == found_.stretches[i].drive &&
             found_.stretches[end].session == found_.stretches[i].session) {
        ++end;
      }
      MoveSession(i, end);
      i = end;
    }
  }

  // The stretches [begin, end) are one session's. It is cut wherever the next one is another map's.
  void MoveSession(std::size_t begin, std::size_t end) {
    const SurveyedSession& session = SessionOf(found_.stretches[begin]);
    if (IsPinned(session.map)) return Move(session, session.map);
    std::size_t first = begin;
    for (std::size_t i = begin; i < end; ++i) {
      const MapId& target = MapOf(found_.stretches[i]);
      if (i + 1 < end && MapOf(found_.stretches[i + 1]) == target) continue;
      const std::size_t visit = found_.stretches[first].first;
      SurveyedSession part = PartOf(session, visit, found_.stretches[i].last);
      if (first > begin) {
        part.id = SessionId(new_id_());
        result_.cuts.push_back({session.id, session.visits[visit].sequence, part.id});
      }
      Move(part, target);
      const bool is_whole = first == begin && i + 1 == end;
      if (is_whole && target == session.map && session.cabin) CutAtCabin(session);
      first = i + 1;
    }
  }

  const MapId& MapOf(const Stretch& stretch) const {
    const auto found = plan_.map_of_room.find(stretch.room);
    return found == plan_.map_of_room.end() ? SessionOf(stretch).map : found->second;
  }

  // What the session recorded from visit `first` to visit `last`, inclusive.
  static SurveyedSession PartOf(const SurveyedSession& session, std::size_t first, std::size_t last) {
    SurveyedSession part;
    part.id = session.id;
    part.map = session.map;
    part.visits.assign(session.visits.begin() + static_cast<std::ptrdiff_t>(first),
                       session.visits.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    return part;
  }

  // What a session recorded in the cabin is the cabin's. One that moves or is cut elsewhere waits for the next survey.
  void CutAtCabin(const SurveyedSession& session) {
    const CabinEntry& entry = *session.cabin;
    const auto door = std::find_if(survey_.link_points.begin(), survey_.link_points.end(),
                                   [&](const graph::LinkPoint& one) { return one.id == entry.door; });
    if (door == survey_.link_points.end() || door->use == graph::LinkPointUse::kSuspended) return;
    const graph::Anchor* hall = door->FindAnchor(session.map);
    const graph::Anchor* cabin = door->FindAnchor(entry.cabin);
    if (hall == nullptr || cabin == nullptr || plan_.successors.contains(entry.cabin)) return;
    const bool reached = std::any_of(entry.visits.begin(), entry.visits.end(), [&](const Visit& visit) {
      return Between(hall->T_map_place, visit.T_map_robot).translation().norm() >= options_.reach;
    });
    if (!reached || session.visits.empty()) return;
    const SessionId rest(new_id_());
    result_.cuts.push_back({session.id, entry.visits.front().sequence, rest});
    const auto T_level_cabin = survey_.cabin_places.find(entry.cabin);
    const Pose2 T_cabin_hall = T_level_cabin != survey_.cabin_places.end()
                                   ? Between(T_level_cabin->second, *PlaceOf(session))
                                   : cabin->T_map_place * Inverse(hall->T_map_place);
    result_.moves.push_back({rest, entry.cabin, T_cabin_hall});
  }

  void Move(const SurveyedSession& part, const MapId& target) {
    const std::optional<Pose2> place = PlaceOf(part);
    if (!place) return;
    driven_into_[part.map][target] += static_cast<double>(part.visits.size());
    if (target == part.map && !MovesWithinMap(part)) return;
    result_.moves.push_back({part.id, target, Between(plan_.T_level_map.at(target), *place)});
  }

  // What stays in its map goes where the survey has it by now. People have decided how sessions of pinned maps lie.
  bool MovesWithinMap(const SurveyedSession& part) const {
    return !IsPinned(part.map) && IsOutOfPlace(part, plan_.T_level_map.at(part.map), options_);
  }

  // Rides stay in their cabin if its map becomes another room's.
  void MoveRides(const rooms::RoomPartition& partition) {
    for (const SurveyedMap& map : survey_.maps) {
      const auto place = plan_.T_level_map.find(map.id);
      if (place == plan_.T_level_map.end() || map.pinned) continue;
      for (const Ride& ride : map.rides) {
        const auto now = plan_.map_of_room.find(RoomOf(ride, place->second, partition));
        if (now == plan_.map_of_room.end() || now->second == map.id) continue;
        MoveRide(ride, map.id, now->second);
        moved_rides_.insert(ride.session);
      }
    }
  }

  // A ride lies in its cabin where the level has it that the robot came from, if another ride has shown how that level
  // and the cabin lie. Elsewhere the survey has seen the door from both sides.
  void PutRidesBegun() {
    constexpr double kApart = 0.02;    // m
    constexpr double kTurned = 0.005;  // rad
    for (const RideBegun& ride : survey_.rides_begun) {
      const auto T_level_cabin = survey_.cabin_places.find(ride.cabin);
      if (T_level_cabin == survey_.cabin_places.end()) continue;
      const Pose2 T_to_from = Between(T_level_cabin->second, ride.T_level_robot) * Inverse(ride.T_cabin_robot);
      const double apart = (T_to_from * ride.T_cabin_robot.translation() - ride.T_cabin_robot.translation()).norm();
      if (apart <= kApart && std::abs(T_to_from.yaw) <= kTurned) continue;
      result_.moves.push_back({ride.session, ride.cabin, T_to_from});
      if (ride.way_out) plan_.moved_ways_out[*ride.way_out] = {ride.cabin, T_to_from};
    }
  }

  // Where most of its keyframes are. 0: in no room.
  static int RoomOf(const Ride& ride, const Pose2& T_level_map, const rooms::RoomPartition& partition) {
    std::map<int, int> keyframes;
    for (const Pose2& T_map_robot : ride.T_map_robot) {
      ++keyframes[partition.RoomAt((T_level_map * T_map_robot).translation())];
    }
    const auto most = std::max_element(keyframes.begin(), keyframes.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return most == keyframes.end() ? 0 : most->first;
  }

  void MoveRide(const Ride& ride, const MapId& from, const MapId& to) {
    result_.moves.push_back({ride.session, to, Between(plan_.T_level_map.at(to), plan_.T_level_map.at(from))});
  }

  void RedirectEmptyMaps() {
    for (const SurveyedMap& map : survey_.maps) {
      const auto targets = driven_into_.find(map.id);
      if (map.busy || targets == driven_into_.end() || targets->second.contains(map.id)) continue;
      const auto most = std::max_element(targets->second.begin(), targets->second.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      const bool rides_stay = std::any_of(map.rides.begin(), map.rides.end(),
                                          [&](const Ride& ride) { return !moved_rides_.contains(ride.session); });
      if (rides_stay && !survey_.cabins.contains(most->first)) continue;
      for (const Ride& ride : map.rides) {
        if (!moved_rides_.contains(ride.session)) MoveRide(ride, map.id, most->first);
      }
      plan_.successors[map.id] = most->first;
      result_.redirects.push_back(
          {map.id, most->first, Between(plan_.T_level_map.at(most->first), plan_.T_level_map.at(map.id))});
      AddReason(fmt::format("maps {} and {} are one room", map.id.value(), most->first.value()));
    }
  }

  void RedirectAwaitedMaps(const rooms::RoomPartition& partition) {
    for (const AwaitedMap& map : survey_.awaited) {
      const auto room = plan_.map_of_room.find(partition.RoomAt(map.T_level_robot.translation()));
      if (room == plan_.map_of_room.end()) continue;
      plan_.T_level_map[map.id] = map.T_level_map;
      plan_.successors[map.id] = room->second;
      result_.redirects.push_back({map.id, room->second, Between(plan_.T_level_map.at(room->second), map.T_level_map)});
      AddReason(fmt::format("map {} is empty, and in the room of map {}", map.id.value(), room->second.value()));
    }
  }

  void AddReason(const std::string& reason) {
    if (!result_.reason.empty()) result_.reason += "; ";
    result_.reason += reason;
  }

  const LevelSurvey& survey_;
  const SurveyOptions& options_;
  const std::function<std::string()>& new_id_;
  RoomsOfDrives found_;
  MapPlan plan_;
  std::map<std::pair<int, MapId>, double> driven_;        // m, in each room, by sessions of each map
  std::map<MapId, std::map<MapId, double>> driven_into_;  // where each map's sessions are now, and how much of them
  std::set<SessionId> moved_rides_;
  rearrange::Rearrangement result_;
};

}  // namespace

rearrange::Rearrangement ArrangeMaps(const LevelSurvey& survey, const rooms::RoomPartition& partition,
                                     const SurveyOptions& options, const std::function<std::string()>& new_id) {
  MapArranger maps(survey, options, new_id, FindRooms(survey, partition, options));
  maps.Run(partition);
  rearrange::Rearrangement result = maps.TakeResult();
  ArrangeDoors({survey, partition, maps.found()}, maps.plan(), options, new_id, result);
  if (!result.empty() && result.reason.empty()) result.reason = "doors and sessions are put where the survey has them";
  return result;
}

}  // namespace enfilade::survey

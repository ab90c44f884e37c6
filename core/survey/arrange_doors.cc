// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/segments.h"
#include "core/graph/same_place.h"
#include "core/survey/doors_ahead.h"
#include "core/survey/map_plan.h"

namespace enfilade::survey {
namespace {

// A door that robots went through.
struct PassedDoor {
  int index = -1;  // of the partition; -1: where a robot crossed without one
  int from = 0;    // rooms
  int to = 0;
  Pose2 T_level_door = {};  // in its middle, looking from `from` to `to`
};

bool JoinSameRooms(int a, int b, int c, int d) { return (a == c && b == d) || (a == d && b == c); }

PassedDoor DoorOf(const Crossing& crossing, const rooms::RoomPartition& partition, double reach) {
  const Eigen::Vector2d before = crossing.T_level_before.translation();
  const Eigen::Vector2d behind = crossing.T_level_behind.translation();
  PassedDoor door{.from = crossing.from,
                  .to = crossing.to,
                  .T_level_door = Interpolate(crossing.T_level_before, crossing.T_level_behind, 0.5)};
  const Eigen::Vector2d way = behind - before;
  if (way.norm() > 1e-3) door.T_level_door.yaw = std::atan2(way.y(), way.x());
  double nearest = reach;
  for (std::size_t i = 0; i < partition.doors.size(); ++i) {
    const rooms::Door& one = partition.doors[i];
    if (!JoinSameRooms(one.rooms[0], one.rooms[1], crossing.from, crossing.to)) continue;
    const Eigen::Vector2d middle = (one.a + one.b) / 2.0;
    const double distance = DistanceToSegment(middle, before, behind);
    if (distance >= nearest + one.width() / 2.0) continue;
    nearest = distance - one.width() / 2.0;
    const Eigen::Vector2d along = one.b - one.a;
    Eigen::Vector2d normal(-along.y(), along.x());
    if (normal.dot(way) < 0.0) normal = -normal;
    door.index = static_cast<int>(i);
    door.T_level_door = {middle.x(), middle.y(), std::atan2(normal.y(), normal.x())};
  }
  return door;
}

class DoorArranger {
 public:
  DoorArranger(const LevelInRooms& level, const MapPlan& plan, const SurveyOptions& options,
               const std::function<std::string()>& new_id, rearrange::Rearrangement& result)
      : survey_(level.survey),
        partition_(level.partition),
        plan_(plan),
        options_(options),
        new_id_(new_id),
        result_(result) {}

  void AddPassed(const PassedDoor& door) {
    const auto known = std::find_if(passed_.begin(), passed_.end(), [&](const PassedDoor& other) {
      if (!JoinSameRooms(other.from, other.to, door.from, door.to)) return false;
      if (other.index == door.index && other.index >= 0) return true;
      return (other.T_level_door.translation() - door.T_level_door.translation()).norm() < options_.same_door;
    });
    if (known == passed_.end()) passed_.push_back(door);
  }

  void Run() {
    for (const PassedDoor& door : passed_) Settle(door);
    for (const graph::LinkPoint& link_point : survey_.link_points) {
      if (!settled_.contains(link_point.id)) Keep(link_point);
    }
  }

 private:
  // A link point as it will be, unless it is suspended.
  struct Arranged {
    graph::LinkPoint link_point = {};
    bool changed = false;  // or new
  };

  const MapId* MapOfRoom(int room) const {
    const auto found = plan_.map_of_room.find(room);
    return found == plan_.map_of_room.end() ? nullptr : &found->second;
  }

  bool IsBusy(const MapId& map) const {
    const SurveyedMap* found = survey_.FindMap(map);
    return found != nullptr && found->stays();
  }

  // People have placed it, or decided about a map that it leads to. `but`: maps that do not count.
  bool IsPinned(const graph::LinkPoint& link_point, const std::set<MapId>& but = {}) const {
    return link_point.pinned ||
           std::any_of(link_point.anchors.begin(), link_point.anchors.end(), [&](const graph::Anchor& anchor) {
             const SurveyedMap* map = survey_.FindMap(anchor.map);
             return map != nullptr && map->pinned && !but.contains(anchor.map);
           });
  }

  // Unset: in a map that was not surveyed.
  std::optional<Pose2> PlaceOfAnchor(const graph::Anchor& anchor) const {
    const auto map = plan_.T_level_map.find(anchor.map);
    if (map == plan_.T_level_map.end()) return std::nullopt;
    return map->second * anchor.T_map_place;
  }

  static bool IsDoor(const graph::LinkPoint& link_point) {
    return link_point.kind == graph::LinkPointKind::kDoor || link_point.kind == graph::LinkPointKind::kOpening;
  }

  // All anchors are in surveyed maps.
  bool IsSurveyed(const graph::LinkPoint& link_point) const {
    return std::all_of(link_point.anchors.begin(), link_point.anchors.end(),
                       [&](const graph::Anchor& anchor) { return plan_.T_level_map.contains(anchor.map); });
  }

  // To the cabin of a lift that is a map of another level, or was entered from one: the survey does not see all who
  // went there.
  bool LeadsToCabin(const graph::LinkPoint& link_point) const {
    return std::any_of(link_point.anchors.begin(), link_point.anchors.end(), [&](const graph::Anchor& anchor) {
      const SurveyedMap* map = survey_.FindMap(anchor.map);
      return survey_.cabins.contains(anchor.map) || (map != nullptr && !map->rides.empty());
    });
  }

  // Robots saw the rooms behind it from both of its sides. That they did not go through says nothing against it.
  bool IsSeenThrough(const graph::LinkPoint& link_point) const { return survey_.seen_through.contains(link_point.id); }

  // The existing link point at the door: preferably one that joins its two maps already. One that would make the door's
  // own redundant is at the door, however far away it is.
  const graph::LinkPoint* FindExisting(const PassedDoor& door, const MapId& from, const MapId& to) const {
    const std::vector<graph::Anchor> anchors = AnchorsOf(door, from, to);
    const graph::LinkPoint* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const graph::LinkPoint& link_point : survey_.link_points) {
      if (link_point.is_candidate() || !IsDoor(link_point) || settled_.contains(link_point.id)) continue;
      if (!IsSurveyed(link_point)) continue;
      double distance = std::numeric_limits<double>::infinity();
      for (const graph::Anchor& anchor : link_point.anchors) {
        const Pose2 place = *PlaceOfAnchor(anchor);
        distance = std::min(distance, (place.translation() - door.T_level_door.translation()).norm());
      }
      if (distance > options_.same_door && !graph::FindCommonPlace(link_point.anchors, anchors)) continue;
      if (link_point.FindAnchor(from) == nullptr || link_point.FindAnchor(to) == nullptr) distance += 10.0;
      if (distance < least) {
        least = distance;
        best = &link_point;
      }
    }
    return best;
  }

  // Does it join the two maps where the survey has the door, and is it about as sure of that?
  bool IsRight(const graph::LinkPoint& link_point, const MapId& from, const MapId& to) const {
    if (link_point.anchors.size() != 2) return false;
    const graph::Anchor* a = link_point.FindAnchor(from);
    const graph::Anchor* b = link_point.FindAnchor(to);
    if (a == nullptr || b == nullptr) return false;
    if (!IsAsSure(*a, VariancesAt(from, to)) || !IsAsSure(*b, VariancesAt(to, from))) return false;
    return AreSamePlace(*PlaceOfAnchor(*a), *PlaceOfAnchor(*b), VariancesOf(from) + VariancesOf(to));
  }

  // Whether the difference is small beside what is stated of it.
  static bool AreSamePlace(const Pose2& one, const Pose2& other, const Eigen::Vector3d& variances) {
    constexpr double kSigmas = 0.3;
    const Pose2 error = Between(one, other);
    return error.translation().norm() <= kSigmas * std::sqrt(variances.x()) &&
           std::abs(error.yaw) <= kSigmas * std::sqrt(variances.z());
  }

  // The variances of a door's anchor in a map: x, y, yaw. However often robots went through, the map bends the same.
  Eigen::Vector3d VariancesOf(const MapId& map) const {
    const auto found = plan_.extents.find(map);
    const double extent = found == plan_.extents.end() ? 0.0 : found->second;
    const double position = std::hypot(options_.door_sigma, options_.bend * extent);
    const double yaw = std::hypot(options_.door_yaw_sigma, options_.yaw_bend * extent);
    return survey_.variance_factor * Eigen::Vector3d(position, position, yaw).cwiseAbs2();
  }

  // Those of the anchor in `map` of a door that leads to `other`. A cabin that robots came to the level in lies there
  // as the ride shows it.
  Eigen::Vector3d VariancesAt(const MapId& map, const MapId& other) const {
    Eigen::Vector3d variances = VariancesOf(map);
    if (survey_.cabin_places.contains(other)) variances.z() += options_.ride_yaw_sigma * options_.ride_yaw_sigma;
    return variances;
  }

  // About as sure as the survey. Of what was surer the survey has seen since that its map is larger, or bends.
  bool IsAsSure(const graph::Anchor& anchor, const Eigen::Vector3d& variances) const {
    const Eigen::Array3d ratios = anchor.covariance.diagonal().array() / variances.array();
    const double limit = options_.as_sure * options_.as_sure;
    return (ratios <= limit).all() && (ratios >= 1.0 / limit).all();
  }

  graph::Anchor AnchorIn(const MapId& map, const MapId& other, const Pose2& T_level_door) const {
    return {map, Between(plan_.T_level_map.at(map), T_level_door), VariancesAt(map, other).asDiagonal()};
  }

  std::vector<graph::Anchor> AnchorsOf(const PassedDoor& door, const MapId& from, const MapId& to) const {
    return {AnchorIn(from, to, door.T_level_door), AnchorIn(to, from, door.T_level_door)};
  }

  // Would the store refuse it beside one of the link points arranged so far? What is stored already may stand beside
  // what does not change.
  bool IsRedundant(const graph::LinkPoint& link_point, bool changed) const {
    return std::any_of(arranged_.begin(), arranged_.end(), [&](const Arranged& other) {
      return (changed || other.changed) && graph::FindCommonPlace(link_point.anchors, other.link_point.anchors);
    });
  }

  // The link point as it will be, with its place among the others. `existing` is the stored one, or null.
  void Arrange(const graph::LinkPoint& link_point, const graph::LinkPoint* existing) {
    const bool changed = existing == nullptr || !(link_point == *existing);
    const bool counts = link_point.use != graph::LinkPointUse::kSuspended;
    if (counts && IsRedundant(link_point, changed)) {
      if (existing != nullptr) Remove(*existing);
      return;
    }
    if (counts) arranged_.push_back({link_point, changed});
    if (changed) result_.link_points.push_back(link_point);
  }

  void Settle(const PassedDoor& door) {
    const MapId* from = MapOfRoom(door.from);
    const MapId* to = MapOfRoom(door.to);
    if (from == nullptr || to == nullptr || *from == *to) return;
    places_.push_back(door.T_level_door);
    const graph::LinkPoint* existing = FindExisting(door, *from, *to);
    if (existing != nullptr) settled_.insert(existing->id);
    if (existing != nullptr && IsPinned(*existing, {*from, *to})) return Keep(*existing);
    if (existing != nullptr && IsRight(*existing, *from, *to)) return Arrange(*existing, existing);
    graph::LinkPoint link_point;
    if (existing != nullptr) {
      link_point = *existing;
    } else {
      link_point.id = LinkPointId(new_id_());
      link_point.kind = graph::LinkPointKind::kDoor;
    }
    link_point.direction = *to;
    link_point.anchors = AnchorsOf(door, *from, *to);
    Arrange(link_point, existing);
  }

  // Unset: its map was not surveyed.
  std::optional<Sighting> SightingOf(const graph::LinkPoint& candidate) const {
    const std::optional<Pose2> place = PlaceOfAnchor(candidate.anchors.front());
    if (!place) return std::nullopt;
    const auto gap = survey_.gaps.find(candidate.id);
    return Sighting{*place, gap == survey_.gaps.end() ? std::nullopt : std::optional(gap->second)};
  }

  // The map of the room that the robot saw the door from.
  MapId MapOfSighting(const graph::Anchor& anchor) const {
    const std::optional<Pose2> place = PlaceOfAnchor(anchor);
    const MapId* map = place ? MapOfRoom(partition_.RoomAt(place->translation())) : nullptr;
    return map != nullptr ? *map : plan_.NowOf(anchor.map);
  }

  // The map of the room on the anchor's side of a door that no robot of this level went through. Maps of other levels
  // stay.
  MapId MapBeforeDoor(const graph::LinkPoint& link_point, const graph::Anchor& anchor) const {
    if (survey_.FindMap(anchor.map) == nullptr) return anchor.map;
    const std::optional<Pose2> place = PlaceOfAnchor(anchor);
    const MapId* map = place ? MapOfRoom(RoomOnSide(partition_, link_point, anchor.map, *place)) : nullptr;
    return map != nullptr ? *map : plan_.NowOf(anchor.map);
  }

  MapId NowOf(const graph::LinkPoint& link_point, const graph::Anchor& anchor) const {
    if (link_point.is_candidate()) return MapOfSighting(anchor);
    const bool is_passed_here = IsSurveyed(link_point) && !LeadsToCabin(link_point) && !IsSeenThrough(link_point);
    return IsDoor(link_point) && !is_passed_here ? MapBeforeDoor(link_point, anchor) : plan_.NowOf(anchor.map);
  }

  // A link point that is at no door that robots went through.
  void Keep(const graph::LinkPoint& link_point) {
    const bool door = IsDoor(link_point);
    const bool busy = std::any_of(link_point.anchors.begin(), link_point.anchors.end(),
                                  [&](const graph::Anchor& anchor) { return IsBusy(anchor.map); });
    if (link_point.is_candidate() && !link_point.pinned) {
      const std::optional<Sighting> sighting = SightingOf(link_point);
      if (sighting && !DoorsAhead(partition_, options_, places_).MayBeUnknown(*sighting)) return Remove(link_point);
    } else if (door && !busy && IsSurveyed(link_point) && !LeadsToCabin(link_point) && !IsPinned(link_point) &&
               !IsSeenThrough(link_point) && link_point.use != graph::LinkPointUse::kSuspended) {
      return Remove(link_point);
    }
    graph::LinkPoint moved = link_point;
    for (graph::Anchor& anchor : moved.anchors) {
      const MapId now = NowOf(link_point, anchor);
      if (now == anchor.map) continue;
      if (link_point.direction == anchor.map) moved.direction = now;
      const PoseWithCovariance there =
          rearrange::Moved(Between(plan_.T_level_map.at(now), plan_.T_level_map.at(anchor.map)),
                           {anchor.T_map_place, anchor.covariance});
      anchor = {now, there.pose, there.covariance};
    }
    MoveWithRide(moved);
    PutAtCabin(moved);
    std::set<MapId> maps;
    std::erase_if(moved.anchors, [&](const graph::Anchor& anchor) { return !maps.insert(anchor.map).second; });
    if (maps.size() < std::min<std::size_t>(link_point.anchors.size(), 2)) {
      return Remove(link_point);  // its maps are one room
    }
    Arrange(moved, &link_point);
  }

  void MoveWithRide(graph::LinkPoint& door) const {
    const auto ride = plan_.moved_ways_out.find(door.id);
    if (ride == plan_.moved_ways_out.end() || door.pinned) return;
    for (graph::Anchor& anchor : door.anchors) {
      if (anchor.map == ride->second.first) anchor.T_map_place = ride->second.second * anchor.T_map_place;
    }
  }

  // A door of a cabin that robots came to the level in is where the cabin is, seen from the hall in front of it.
  void PutAtCabin(graph::LinkPoint& door) const {
    if (door.is_candidate() || door.pinned || door.anchors.size() != 2) return;
    for (std::size_t i = 0; i < 2; ++i) {
      const graph::Anchor& cabin = door.anchors[i];
      graph::Anchor& hall = door.anchors[1 - i];
      const auto T_level_hall = plan_.T_level_map.find(hall.map);
      if (T_level_hall == plan_.T_level_map.end() || survey_.cabins.contains(hall.map)) continue;
      const auto T_level_cabin = plan_.T_level_map.find(cabin.map);
      if (T_level_cabin == plan_.T_level_map.end() || !survey_.cabin_places.contains(cabin.map)) continue;
      const graph::Anchor now = AnchorIn(hall.map, cabin.map, T_level_cabin->second * cabin.T_map_place);
      const bool is_same = AreSamePlace(hall.T_map_place, now.T_map_place, VariancesOf(hall.map));
      if (is_same && IsAsSure(hall, now.covariance.diagonal())) continue;
      hall = now;
    }
  }

  void Remove(const graph::LinkPoint& link_point) { result_.removed_link_points.push_back(link_point.id); }

  const LevelSurvey& survey_;
  const rooms::RoomPartition& partition_;
  const MapPlan& plan_;
  const SurveyOptions& options_;
  const std::function<std::string()>& new_id_;
  rearrange::Rearrangement& result_;
  std::vector<PassedDoor> passed_;
  std::vector<Pose2> places_;      // T_level_door of the passed doors
  std::set<LinkPointId> settled_;  // the existing link points of passed doors
  std::vector<Arranged> arranged_;
};

}  // namespace

void ArrangeDoors(const LevelInRooms& level, const MapPlan& plan, const SurveyOptions& options,
                  const std::function<std::string()>& new_id, rearrange::Rearrangement& result) {
  DoorArranger doors(level, plan, options, new_id, result);
  for (const Crossing& crossing : level.found.crossings) {
    doors.AddPassed(DoorOf(crossing, level.partition, options.same_door));
  }
  doors.Run();
}

}  // namespace enfilade::survey

// SPDX-License-Identifier: Apache-2.0
// A campus that is merged, split and undone a thousand times at random, as people and surveys may do in a year.
#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "core/base/status_macros.h"
#include "tests/unit/server/app/rearrange/rearranged_campus.h"

namespace enfilade::server {
namespace {

using ::testing::SizeIs;

constexpr int kRooms = 12;
constexpr int kMapsOfRoom = 3;
constexpr int kRearrangements = 1000;

// A row of rooms with a door between each and the next. Each was begun as three maps, with one session each; the maps
// of a room are joined, and each has the room's doors. Where everything is in the world is known.
class WholeCampus : public RearrangedCampus, public ::testing::WithParamInterface<unsigned> {
 protected:
  WholeCampus() {
    for (int room = 0; room < kRooms; ++room) {
      for (int i = 0; i < kMapsOfRoom; ++i) AddRoomMap(room, i);
      for (int i = 1; i < kMapsOfRoom; ++i) Connect(fmt::format("in-{}-{}", room, i), {room, i - 1}, {room, i}, 2.0);
      if (room == 0) continue;
      for (int i = 0; i < kMapsOfRoom; ++i) Connect(fmt::format("door-{}-{}", room, i), {room - 1, i}, {room, i}, 0.0);
    }
  }

  using RoomMap = std::pair<int, int>;  // of the room; of its maps
  static std::string NameOfMap(const RoomMap& map) { return fmt::format("m-{}-{}", map.first, map.second); }
  // Map 0 of room 0 is the root: its frame is the world's.
  static Pose2 PlaceOf(const RoomMap& map) {
    const auto [room, i] = map;
    return room + i == 0 ? Pose2{} : Pose2{10.0 * room + 1.5 * i, 0.5 * i, 0.4 * i - 0.1 * room};
  }
  void AddRoomMap(int room, int i) {
    const std::string map = NameOfMap({room, i});
    AddMap(map);
    const Pose2 T_world_robot{10.0 * room + 3.0 + i, 1.0, 0.3 * i};
    const SessionId session(fmt::format("s-{}-{}", room, i));
    AddMapped(session.value(), map, Between(PlaceOf({room, i}), T_world_robot));
    room_of_[session] = room;
    truth_[session] = T_world_robot;
  }
  // At x = 10 m times b's room, `beside` m to the side.
  void Connect(const std::string& id, const RoomMap& a, const RoomMap& b, double beside) {
    const Pose2 T_world_place{10.0 * b.first + 0.1 * b.second * (beside > 0.0 ? 1.0 : 0.0), beside, 0.0};
    Join(id, NameOfMap(a), Between(PlaceOf(a), T_world_place), NameOfMap(b), Between(PlaceOf(b), T_world_place), 0.01);
  }

  std::set<MapId> MapsOfRoom(int room) const {
    std::set<MapId> maps;
    for (const auto& [session, of] : room_of_) {
      if (of == room) maps.insert(MapOf(session));
    }
    return maps;
  }
  // By where both lie in the world, as a survey has it.
  absl::StatusOr<storage::StoredRearrangement> MergeInPlace(const MapId& kept, const MapId& merged) {
    ENFILADE_ASSIGN_OR_RETURN(const auto stored, stores_.graphs.GetPlaces(Soon(), site_, {kept, merged}));
    std::map<MapId, Pose2> places;
    for (const storage::MapPose& place : stored) places[place.map] = place.T_world_map.pose;
    return Merge(kept.value(), merged.value(), Between(places.at(kept), places.at(merged)));
  }
  // A merge, a split or an undo in any room; unset if there is nothing of that kind to do.
  std::optional<absl::StatusOr<storage::StoredRearrangement>> DoAnything() {
    const auto below = [&](std::size_t n) { return random_() % n; };
    const std::set<MapId> maps = MapsOfRoom(static_cast<int>(below(kRooms)));
    std::vector<MapId> order(maps.begin(), maps.end());
    std::shuffle(order.begin(), order.end(), random_);
    switch (below(5)) {
      case 0:
      case 1:
        if (order.size() < 2) return std::nullopt;
        return MergeInPlace(order[0], order[1]);
      case 2:
      case 3: {
        std::vector<SessionId> inside;
        for (const auto& [session, of] : room_of_) {
          if (MapOf(session) == order[0]) inside.push_back(session);
        }
        if (inside.size() < 2) return std::nullopt;
        return Split(order[0].value(), {inside[below(inside.size())]}, fmt::format("split-{}", ++split_));
      }
      default:
        if (made_.empty()) return std::nullopt;
        const rearrange::RearrangementId last = made_.back();
        made_.pop_back();
        return Undo(last);
    }
  }
  void ExpectEverythingInItsPlace() {
    for (const auto& [session, T_world_robot] : truth_) {
      ASSERT_THAT(WorldPoseOf(session), testing::PoseNear(T_world_robot, 1e-6, 1e-6)) << session.value();
    }
  }

  std::mt19937 random_{GetParam()};
  std::map<SessionId, int> room_of_;
  std::map<SessionId, Pose2> truth_;
  std::vector<rearrange::RearrangementId> made_;  // and not undone
  int split_ = 0;
};

TEST_P(WholeCampus, AnyOrderOfAThousandRearrangementsEndsInTheSameRooms) {
  ExpectEverythingInItsPlace();
  for (int done = 0; done < kRearrangements;) {
    const std::int64_t version = Version();
    const auto one = DoAnything();
    if (!one) continue;
    ASSERT_OK(*one) << "after " << done;
    ASSERT_EQ(Version(), version + 1);
    if ((*one)->version_undone == 0) made_.push_back((*one)->id);
    if (++done % 100 == 0) ExpectEverythingInItsPlace();
  }
  // Then the maps of each room are merged.
  for (int room = 0; room < kRooms; ++room) {
    for (std::set<MapId> maps = MapsOfRoom(room); maps.size() > 1; maps = MapsOfRoom(room)) {
      ASSERT_OK(MergeInPlace(*maps.begin(), *maps.rbegin()));
    }
  }
  ExpectEverythingInItsPlace();
  EXPECT_THAT(*stores_.maps.List(Soon(), site_, storage::PageRequest{}), SizeIs(kRooms));
  EXPECT_THAT(*stores_.graphs.GetPlaces(Soon(), site_, {}), SizeIs(kRooms));
  ASSERT_OK_AND_ASSIGN(const auto doors, stores_.link_points.List(Soon(), site_, {}, storage::PageRequest{}));
  EXPECT_THAT(doors, SizeIs(kRooms - 1)) << "one for each door";
  for (int room = 0; room < kRooms; ++room) {
    const std::set<MapId> maps = MapsOfRoom(room);
    ASSERT_THAT(maps, SizeIs(1));
    // Every name that any of the room's maps ever had leads there.
    for (int i = 0; i < kMapsOfRoom; ++i) {
      EXPECT_EQ(stores_.maps.Get(Soon(), site_, MapId(NameOfMap({room, i})))->id, *maps.begin());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, WholeCampus, ::testing::Range(1U, 4U));

}  // namespace
}  // namespace enfilade::server

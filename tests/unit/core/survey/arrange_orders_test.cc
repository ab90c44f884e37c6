// SPDX-License-Identifier: Apache-2.0
#include <random>

#include "gtest/gtest.h"
#include "tests/unit/core/survey/drawn_level.h"

namespace enfilade::survey {
namespace {

// Drives through the corridor's rooms, cut into sessions anywhere and mapped into maps at random: what robots and
// verdicts at doors might make of them at worst.
LevelSurvey RandomBeginnings(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const std::vector<std::vector<Eigen::Vector2d>> stops = {
      {{1.5, 1.0}, {1.5, 4.0}, {5.0, 4.0}, {5.0, 6.5}, {4.0, 6.5}, {5.0, 6.5}, {5.0, 4.0}, {9.0, 4.0}},
      {{9.0, 4.0}, {1.5, 4.0}, {1.5, 1.0}, {3.0, 1.0}, {1.5, 1.0}, {1.5, 4.0}, {3.0, 4.0}}};
  LevelSurvey survey;
  int session = 0;
  std::map<std::string, Pose2> places;
  for (const auto& way : stops) {
    std::vector<Leg> legs;
    for (std::size_t i = 0; i + 1 < way.size(); ++i) {
      const Eigen::Vector2d middle = way[i] + (way[i + 1] - way[i]) * (0.2 + 0.06 * below(10));
      const std::string map = "m" + std::to_string(below(5));
      if (!places.contains(map)) places[map] = {0.5 * below(20), 0.5 * below(20), 0.3 * below(20)};
      if (legs.empty() || below(2) == 0) {
        if (!legs.empty()) legs.back().points.push_back(middle);
        const Eigen::Vector2d start = legs.empty() ? way[i] : middle;
        legs.push_back({"s" + std::to_string(++session), map, places[map], {start}});
      }
      legs.back().points.push_back(way[i + 1]);
    }
    survey.drives.push_back(MakeDrive(legs));
  }
  std::set<MapId> used;
  for (const Drive& drive : survey.drives) {
    for (const SurveyedSession& one : drive) used.insert(one.map);
  }
  for (const MapId& map : used) survey.maps.push_back({.id = map});
  survey.maps[static_cast<std::size_t>(below(static_cast<int>(survey.maps.size())))].root = true;
  return survey;
}

class ArrangeOrders : public ::testing::TestWithParam<int> {};

TEST_P(ArrangeOrders, EndInTheSamePartition) {
  const rooms::RoomPartition partition = Corridor();
  for (int i = 0; i < 50; ++i) {
    const auto seed = static_cast<std::uint32_t>(50 * GetParam() + i);
    SCOPED_TRACE(seed);
    const LevelSurvey before = RandomBeginnings(seed);
    // Each survey cuts a session once.
    LevelSurvey after = before;
    const auto new_id = NumberedIds();
    for (int survey = 0; survey < 8; ++survey) {
      const rearrange::Rearrangement change = ArrangeMaps(after, partition, {}, new_id);
      ASSERT_TRUE(rearrange::Validate(change).ok()) << rearrange::Validate(change);
      if (change.empty()) break;
      after = After(after, change);
    }
    // Each room has one map of its own, and each door one link point.
    std::set<std::string> maps;
    for (const auto& [room, of_room] : MapsOfRooms(after, partition)) {
      ASSERT_EQ(of_room.size(), 1u) << "room " << room;
      EXPECT_TRUE(maps.insert(*of_room.begin()).second) << "room " << room;
    }
    EXPECT_EQ(maps.size(), 3u);
    EXPECT_EQ(after.maps.size(), 3u);
    EXPECT_EQ(JoinedMaps(after).size(), 2u);
    // No pose in the level's frame has changed: only maps' frames have.
    for (const Drive& drive : after.drives) {
      std::map<MapId, Pose2> places;
      for (const SurveyedSession& session : drive) {
        const std::optional<Pose2> place = PlaceOf(session);
        if (!place) continue;
        const auto known = places.emplace(session.map, *place).first;
        EXPECT_LT(Between(known->second, *place).translation().norm(), 1e-6);
      }
    }
    // Then nothing changes any more.
    EXPECT_TRUE(ArrangeMaps(after, partition, {}, NumberedIds()).empty());
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ArrangeOrders, ::testing::Range(0, 20));

}  // namespace
}  // namespace enfilade::survey

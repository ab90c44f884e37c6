// SPDX-License-Identifier: Apache-2.0
// Whichever robot comes first, the site's graph with a plan ends at the same solution.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "core/graph/graph_optimization.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/plans/row_of_rooms.h"

namespace enfilade::graph {
namespace {

using ::testing::IsEmpty;

using Row = testing::RowOfRooms;

constexpr int kSessions = 4;
constexpr double kSame = 0.001;  // m
constexpr double kSameYaw = 0.0001;

// Each session maps a room of its own. A door joins it with a neighbour as soon as both are there.
class Sessions {
 public:
  explicit Sessions(unsigned seed, double wrong = 0.0) : row_(kSessions, 0.1, seed) {
    row_.Bend(0.02);
    for (int room = 0; room < kSessions; ++room) row_.SeeAll(room);
    for (const int room : {0, 2}) doors_.push_back(row_.Door(room, 0.03, 1.0 * kDegree));
    // Of room 3, one wall is taken for another.
    Pose2& line = row_.ties().sightings.back().T_map_line;
    line = line * Pose2{0.0, wrong, 0.0};
    ties_ = row_.ties();
  }

  // The graph is solved after each session, from where the one before has left it. The first map is the root.
  SolvedGraph After(const std::vector<int>& order) const {
    GraphSnapshot graph;
    std::vector<MapId> maps;
    for (const int room : order) {
      maps.push_back(Row::Map(room));
      PlanTies ties = ties_;
      ties.KeepMaps(maps);
      SnapshotChanges changes{.version = graph.version() + 1, .maps = {{.id = Row::Map(room)}}};
      for (const LinkPoint& door : doors_) {
        const bool is_new = std::any_of(door.anchors.begin(), door.anchors.end(),
                                        [&](const Anchor& anchor) { return anchor.map == Row::Map(room); });
        const bool is_known = std::all_of(door.anchors.begin(), door.anchors.end(), [&](const Anchor& anchor) {
          return anchor.map == Row::Map(room) || graph.FindMap(anchor.map) != nullptr;
        });
        if (is_new && is_known) changes.link_points.push_back(door);
      }
      changes.plans = {
          {PriorMapId("p"), testing::Numbered("digest", maps.size()), std::make_shared<const PlanTies>(ties)}};
      graph = Apply(graph, changes).value();
      graph = Apply(graph, ChangesOf(graph, OptimizeGraph(graph).value(), graph.version() + 1)).value();
    }
    return *graph.solution();
  }

 private:
  Row row_;
  PlanTies ties_;  // of all sessions
  std::vector<LinkPoint> doors_;
};

// All orders of sessions, against the first one.
void ExpectTheSameInAnyOrder(const Sessions& sessions) {
  std::vector<int> order(kSessions);
  std::iota(order.begin(), order.end(), 0);
  const SolvedGraph first = sessions.After(order);
  ASSERT_THAT(first.disconnected, IsEmpty()) << first.plans.at(0).contradiction;
  const auto in_room_0 = [](const SolvedGraph& solution, int room) {
    return Between(solution.map_poses.at(Row::Map(0)).pose, solution.map_poses.at(Row::Map(room)).pose);
  };
  int orders = 1;
  for (; std::next_permutation(order.begin(), order.end()); ++orders) {
    const SolvedGraph solution = sessions.After(order);
    ASSERT_THAT(solution.disconnected, IsEmpty()) << ::testing::PrintToString(order);
    EXPECT_EQ(solution.plans.at(0).used, first.plans.at(0).used) << ::testing::PrintToString(order);
    for (int room = 1; room < kSessions; ++room) {
      const Pose2 off = Between(in_room_0(first, room), in_room_0(solution, room));
      EXPECT_LT(off.translation().norm(), kSame) << ::testing::PrintToString(order) << ", room " << room;
      EXPECT_LT(std::abs(off.yaw), kSameYaw) << ::testing::PrintToString(order) << ", room " << room;
    }
  }
  EXPECT_EQ(orders, 24);
}

TEST(SessionOrder, SessionsInAnyOrderGiveTheSameSolution) {
  for (unsigned seed = 1; seed <= 20; ++seed) ExpectTheSameInAnyOrder(Sessions(seed));
}

TEST(SessionOrder, AlsoWhenAWallIsTakenForAnother) {
  for (unsigned seed = 1; seed <= 20; ++seed) ExpectTheSameInAnyOrder(Sessions(seed, 0.8));
}

}  // namespace
}  // namespace enfilade::graph

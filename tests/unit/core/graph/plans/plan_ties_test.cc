// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/plan_ties.h"

#include <gmock/gmock.h>

#include <limits>

#include "core/graph/plans/shared_walls.h"
#include "tests/support/plans/sample_ties.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::M;

TEST(PlanTiesTest, AreReadAsTheyWereWritten) {
  ASSERT_OK_AND_ASSIGN(const PlanTies read, DecodePlanTies(EncodePlanTies(SampleTies())));
  EXPECT_EQ(read, SampleTies());
}

TEST(PlanTiesTest, WithoutShaftsTheyAreWhatEarlierServersRead) {
  PlanTies ties = SampleTies();
  ties.shafts.clear();
  const std::string bytes = EncodePlanTies(ties);
  EXPECT_EQ(bytes[0], 1);
  ASSERT_OK_AND_ASSIGN(const PlanTies read, DecodePlanTies(bytes));
  EXPECT_EQ(read, ties);
}

TEST(PlanTiesTest, WhatWasSeenInOtherMapsIsDropped) {
  PlanTies ties = SampleTies();
  ties.KeepMaps({M("a"), M("c")});
  EXPECT_TRUE(ties.HasSeen(M("a")));
  EXPECT_FALSE(ties.HasSeen(M("b")));
  EXPECT_EQ(ties.sightings, SampleTies().sightings);
  ties.KeepMaps({M("b")});
  EXPECT_TRUE(ties.sightings.empty());
  EXPECT_TRUE(ties.maps.empty());
}

PlanTies Rooms(int first, int count) {
  PlanTies ties;
  for (int i = first; i <= first + count; ++i) {
    const int corner = static_cast<int>(ties.corners.size());
    ties.corners.insert(ties.corners.end(), {{5.0 * i, 0.0}, {5.0 * i, 4.0}});
    ties.struts.push_back({corner, corner + 1, i});
    if (i == first) continue;
    ties.struts.push_back({corner - 2, corner, 100 + i});
    ties.struts.push_back({corner - 1, corner + 1, 200 + i});
  }
  return ties;
}

TEST(ShareOfWallsTest, IsThatOfTheShorterPlan) {
  EXPECT_EQ(ShareOfWalls(Rooms(0, 4), Rooms(0, 4)), 1.0);
  EXPECT_EQ(ShareOfWalls(Rooms(1, 2), Rooms(0, 4)), 1.0);
  EXPECT_EQ(ShareOfWalls(Rooms(0, 4), Rooms(1, 2)), 1.0);
  EXPECT_GT(ShareOfWalls(Rooms(0, 4), Rooms(2, 4)), 0.4);
  EXPECT_LT(ShareOfWalls(Rooms(0, 4), Rooms(4, 4)), 0.2) << "they have one wall in common";
  EXPECT_EQ(ShareOfWalls(Rooms(0, 4), Rooms(10, 4)), 0.0);
  EXPECT_EQ(ShareOfWalls(Rooms(0, 4), PlanTies()), 0.0);
}

TEST(PlanTiesTest, EveryCutIsNoticed) {
  const std::string bytes = EncodePlanTies(SampleTies());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_CODE(DecodePlanTies(bytes.substr(0, size)), absl::StatusCode::kDataLoss) << size;
  }
  EXPECT_CODE(DecodePlanTies(bytes + "x"), absl::StatusCode::kDataLoss);
}

TEST(PlanTiesTest, WhatMakesNoSenseIsRefused) {
  const auto refused = [](void (*damage)(PlanTies&)) {
    PlanTies ties = SampleTies();
    damage(ties);
    EXPECT_CODE(DecodePlanTies(EncodePlanTies(ties)), absl::StatusCode::kDataLoss);
  };
  refused([](PlanTies& ties) { ties.struts[0].to = 3; });
  refused([](PlanTies& ties) { ties.struts[0].to = ties.struts[0].from; });
  refused([](PlanTies& ties) { ties.sightings[0].strut = 2; });
  refused([](PlanTies& ties) { ties.sightings[0].map = M("c"); });
  refused([](PlanTies& ties) { ties.sightings[0].across_sigma = 0; });
  refused([](PlanTies& ties) { ties.maps[1].T_plan_map.x = std::numeric_limits<double>::quiet_NaN(); });
  refused([](PlanTies& ties) { ties.corner_sigma = -1; });
  refused([](PlanTies& ties) { ties.shafts[0].held_by[1] = 3; });
  refused([](PlanTies& ties) { ties.shafts[0].outline.resize(2), ties.shafts[0].held_by.resize(2); });
  refused([](PlanTies& ties) { ties.shafts[0].name = ""; });
  refused([](PlanTies& ties) { ties.shafts[0].outline[2].y() = std::numeric_limits<double>::infinity(); });
  std::string newer = EncodePlanTies(SampleTies());
  newer[0] = 3;
  EXPECT_CODE(DecodePlanTies(newer), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace enfilade::graph

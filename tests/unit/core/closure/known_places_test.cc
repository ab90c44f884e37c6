// SPDX-License-Identifier: Apache-2.0
#include "core/closure/known_places.h"

#include <random>
#include <tuple>
#include <vector>

#include "gmock/gmock.h"

namespace enfilade::closure {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

const MapId kHall("hall");
const MapId kYard("yard");

graph::LinkPoint Place(const std::string& id, std::vector<graph::Anchor> anchors) {
  graph::LinkPoint place;
  place.id = LinkPointId(id);
  place.anchors = std::move(anchors);
  for (graph::Anchor& anchor : place.anchors) anchor.covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
  return place;
}

PoseWithCovariance At(double x, double y, double yaw) {
  return {{x, y, yaw}, Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal()};
}

class KnownPlacesTest : public ::testing::Test {
 protected:
  // Seen from (4, 2), looking north.
  const graph::LinkPoint candidate_ = Place("candidate", {{kHall, {4, 2, M_PI_2}, {}}});
  // At (10, 4), to the east.
  const graph::LinkPoint door_ = Place("door", {{kYard, {0, 0, 0}, {}}, {kHall, {10, 4, 0}, {}}});
  const graph::LinkPoint elsewhere_ = Place("elsewhere", {{kYard, {4, 2, M_PI_2}, {}}});
  const std::vector<const graph::LinkPoint*> all_{&candidate_, &door_, &elsewhere_};
  const DoorClosureOptions options_;
};

TEST_F(KnownPlacesTest, ADoorSeenAgainFromAMetreAwayIsKnown) {
  ASSERT_THAT(FindSighted(all_, kHall, At(4.3, 1.0, M_PI_2 + 0.3), options_), SizeIs(1));
  EXPECT_EQ(FindSighted(all_, kHall, At(4.3, 1.0, M_PI_2 + 0.3), options_)[0].link_point, &candidate_);
}

TEST_F(KnownPlacesTest, ADoorSeenElsewhereOrTheOtherWayIsNot) {
  EXPECT_THAT(FindSighted(all_, kHall, At(4.0, 5.0, M_PI_2), options_), IsEmpty());
  EXPECT_THAT(FindSighted(all_, kHall, At(6.0, 2.0, M_PI_2), options_), IsEmpty());
  EXPECT_THAT(FindSighted(all_, kHall, At(4.0, 2.0, -M_PI_2), options_), IsEmpty());
}

TEST_F(KnownPlacesTest, ALinkPointAheadIsTheDoorThatIsSeen) {
  EXPECT_THAT(FindSighted(all_, kHall, At(7.5, 4.2, 0.1), options_), SizeIs(1));
  EXPECT_THAT(FindSighted(all_, kHall, At(7.5, 4.2, 1.3), options_), IsEmpty());
  EXPECT_THAT(FindSighted(all_, kHall, At(12.5, 4.0, 0.0), options_), IsEmpty());  // it lies behind
  // Anchors of doors may point either way.
  const graph::LinkPoint turned = Place("turned", {{kHall, {10, 4, M_PI}, {}}, {kYard, {}, {}}});
  EXPECT_THAT(FindSighted({&turned}, kHall, At(7.5, 4.2, 0.1), options_), SizeIs(1));
}

TEST_F(KnownPlacesTest, SuspendedPlacesDoNotCount) {
  graph::LinkPoint suspended = candidate_;
  suspended.use = graph::LinkPointUse::kSuspended;
  EXPECT_THAT(FindSighted({&suspended}, kHall, At(4, 2, M_PI_2), options_), IsEmpty());
}

TEST_F(KnownPlacesTest, APassedDoorIsKnownEitherWayRound) {
  EXPECT_THAT(FindPassed(all_, kHall, At(10.3, 4.2, 0.1), options_), SizeIs(1));
  EXPECT_THAT(FindPassed(all_, kHall, At(10.3, 4.2, 0.1 + M_PI), options_), SizeIs(1));
  EXPECT_THAT(FindPassed(all_, kHall, At(10.0, 5.2, 0.0), options_), IsEmpty());  // the next door
  EXPECT_THAT(FindPassed(all_, MapId("none"), At(10.0, 4.0, 0.0), options_), IsEmpty());
}

TEST_F(KnownPlacesTest, TheLikeliestOfTwoComesFirst) {
  const graph::LinkPoint next = Place("next", {{kYard, {3, 3, 0}, {}}, {kHall, {10, 4.5, 0}, {}}});
  const auto found = FindPassed({&next, &door_}, kHall, At(10, 4.1, 0), options_);
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].link_point, &door_);
}

TEST_F(KnownPlacesTest, ACandidateOfThisSideIsFoundWhenItsDoorIsPassed) {
  // The door that was seen from (4, 2) lies at (4, 3.7).
  const auto found = FindPassed(all_, kHall, At(4.1, 3.7, M_PI_2), options_);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].link_point, &candidate_);
  EXPECT_THAT(FindPassed(all_, kHall, At(4.1, 3.7, -M_PI_2), options_), IsEmpty());  // out of it, not into it
}

// Who comes into the hall sees the hall, whichever door it came by.
TEST_F(KnownPlacesTest, TheDoorMustBeWhereThePlaceSaysItIs) {
  const graph::Anchor& seen_from = candidate_.anchors[0];  // (4, 2), looking north
  EXPECT_TRUE(IsDoorOf(candidate_, seen_from, At(4.2, 4.0, -M_PI_2 + 0.2), options_));
  EXPECT_FALSE(IsDoorOf(candidate_, seen_from, At(4.2, 4.0, M_PI_2), options_));    // out of the hall
  EXPECT_FALSE(IsDoorOf(candidate_, seen_from, At(8.0, 4.0, -M_PI_2), options_));   // the next door
  EXPECT_FALSE(IsDoorOf(candidate_, seen_from, At(4.0, -3.0, -M_PI_2), options_));  // behind its back
  const graph::Anchor& at_door = door_.anchors[1];
  EXPECT_TRUE(IsDoorOf(door_, at_door, At(10.2, 4.1, M_PI), options_));
  EXPECT_FALSE(IsDoorOf(door_, at_door, At(10.0, 6.0, M_PI), options_));
}

// At (d, a) as the robot sees it, which is at the origin and looks along x: is it known?
TEST_F(KnownPlacesTest, TheReachOfSightingsAndLinkPointsHasTheseBounds) {
  struct Case {
    double ahead;
    double aside;
    double turned;  // deg
    bool sighting;
    bool link_point;
  };
  const std::vector<Case> cases = {
      {0.0, 0.0, 0, true, true},     {1.4, 0.0, 0, true, true},     {1.7, 0.0, 0, false, true},
      {3.4, 0.0, 0, false, true},    {3.7, 0.0, 0, false, false},   {-0.4, 0.0, 0, true, true},
      {-0.7, 0.0, 0, true, false},   {-1.4, 0.0, 0, true, false},   {-1.7, 0.0, 0, false, false},
      {1.0, 0.9, 0, true, true},     {1.0, -0.9, 0, true, true},    {1.0, 1.1, 0, false, false},
      {1.0, -1.1, 0, false, false},  {1.0, 0.0, 44, true, true},    {1.0, 0.0, -44, true, true},
      {1.0, 0.0, 46, false, false},  {1.0, 0.0, 180, false, true},  {1.0, 0.0, 140, false, true},
      {1.0, 0.0, -140, false, true}, {1.0, 0.0, 130, false, false}, {1.0, 0.0, 90, false, false},
  };
  for (const Case& one : cases) {
    const Pose2 pose{one.ahead, one.aside, one.turned * M_PI / 180.0};
    const graph::LinkPoint sighting = Place("sighting", {{kHall, pose, {}}});
    const graph::LinkPoint door = Place("door", {{kHall, pose, {}}, {kYard, {}, {}}});
    EXPECT_EQ(!FindSighted({&sighting}, kHall, At(0, 0, 0), options_).empty(), one.sighting)
        << one.ahead << " " << one.aside << " " << one.turned;
    EXPECT_EQ(!FindSighted({&door}, kHall, At(0, 0, 0), options_).empty(), one.link_point)
        << one.ahead << " " << one.aside << " " << one.turned;
  }
}

TEST_F(KnownPlacesTest, TheReachGrowsWithTheUncertaintyOfBothPoses) {
  const graph::LinkPoint far = Place("far", {{kHall, {3.0, 0, 0}, {}}});
  EXPECT_THAT(FindSighted({&far}, kHall, At(0, 0, 0), options_), IsEmpty());
  PoseWithCovariance unsure = At(0, 0, 0);
  unsure.covariance(0, 0) = 1.0;  // 2.45 m, 95 %
  EXPECT_THAT(FindSighted({&far}, kHall, unsure, options_), SizeIs(1));
  graph::LinkPoint vague = far;
  vague.anchors[0].covariance(1, 1) = 1.0;
  EXPECT_THAT(FindSighted({&vague}, kHall, At(0, 0, 0), options_), SizeIs(1)) << "the circle, in all directions";
}

TEST_F(KnownPlacesTest, TheNearestSightingComesFirstAndOfEqualsTheFirstById) {
  const graph::LinkPoint near = Place("near", {{kHall, {0.3, 0, 0}, {}}});
  const graph::LinkPoint far = Place("far", {{kHall, {0.9, 0, 0}, {}}});
  const graph::LinkPoint same = Place("a-near", {{kHall, {0.3, 0, 0}, {}}});
  const auto found = FindSighted({&far, &near, &same}, kHall, At(0, 0, 0), options_);
  ASSERT_THAT(found, SizeIs(3));
  EXPECT_EQ(found[0].link_point, &same);
  EXPECT_EQ(found[1].link_point, &near);
  EXPECT_EQ(found[2].link_point, &far);
  EXPECT_NEAR(found[2].distance, 0.9, 1e-12);
}

TEST_F(KnownPlacesTest, WhereTheMapsFrameIsDoesNotMatter) {
  std::mt19937 random(3);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution<>(from, to)(random); };
  for (int i = 0; i < 200; ++i) {
    const Pose2 place{uniform(-2, 5), uniform(-2, 2), uniform(-3.1, 3.1)};
    const Pose2 move{uniform(-99, 99), uniform(-99, 99), uniform(-3.1, 3.1)};
    const bool is_candidate = i % 2 == 0;
    const auto find = [&](const Pose2& T_new_old, bool passed) {
      graph::LinkPoint point = is_candidate ? Place("p", {{kHall, T_new_old * place, {}}})
                                            : Place("p", {{kHall, T_new_old * place, {}}, {kYard, {}, {}}});
      const Pose2 robot = T_new_old * Pose2{0, 0, 0};
      const PoseWithCovariance pose = At(robot.x, robot.y, robot.yaw);
      return passed ? FindPassed({&point}, kHall, pose, options_).size()
                    : FindSighted({&point}, kHall, pose, options_).size();
    };
    for (const bool passed : {false, true}) EXPECT_EQ(find(move, passed), find({}, passed)) << i;
  }
}

// A passage through the door of a candidate is one that the candidate's robot would have seen ahead.
TEST_F(KnownPlacesTest, ASightingIsOfTheDoorThatIsAheadOfIt) {
  for (const auto& [x, y, yaw, found] :
       std::vector<std::tuple<double, double, double, bool>>{{1.7, 0.0, 0.0, true},
                                                             {3.0, 0.0, 0.0, true},
                                                             {0.4, 0.0, 0.0, true},
                                                             {3.4, 0.0, 0.0, false},
                                                             {1.7, 0.9, 0.0, true},
                                                             {1.7, 1.2, 0.0, false},
                                                             {1.7, 0.0, 0.5, true},
                                                             {1.7, 0.0, M_PI, false}}) {
    const graph::LinkPoint sighting = Place("sighting", {{kHall, {0, 0, 0}, {}}});
    EXPECT_EQ(FindPassed({&sighting}, kHall, At(x, y, yaw), options_).size() == 1, found)
        << x << " " << y << " " << yaw;
  }
}

}  // namespace
}  // namespace enfilade::closure

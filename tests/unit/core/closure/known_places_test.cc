// SPDX-License-Identifier: Apache-2.0
#include "core/closure/known_places.h"

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

}  // namespace
}  // namespace enfilade::closure

// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/link_point_rules.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/status_assertions.h"

namespace enfilade::storage {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

graph::Anchor At(const std::string& map, double x) { return {MapId(map), {x, 0, 0}, graph::DefaultAnchorCovariance()}; }

StoredLinkPoint Join(const std::string& id, std::vector<graph::Anchor> anchors) {
  StoredLinkPoint link_point;
  link_point.site = SiteId("campus");
  link_point.point.id = LinkPointId(id);
  link_point.point.anchors = std::move(anchors);
  return link_point;
}

std::vector<std::string> MapsOf(const StoredLinkPoint& link_point) {
  std::vector<std::string> maps;
  for (const graph::Anchor& anchor : link_point.point.anchors) maps.push_back(anchor.map.value());
  return maps;
}

TEST(CompareAnchorsTest, AnAddedAnchorCountsMoreThanAMovedOne) {
  const std::vector<graph::Anchor> before = {At("a", 1), At("b", 2)};
  EXPECT_EQ(CompareAnchors(before, before), AnchorChange::kNone);
  EXPECT_EQ(CompareAnchors(before, {At("b", 2), At("a", 1)}), AnchorChange::kNone) << "in another order";
  EXPECT_EQ(CompareAnchors(before, {At("a", 1)}), AnchorChange::kNone) << "without one of them";
  EXPECT_EQ(CompareAnchors(before, {At("a", 1), At("b", 2.5)}), AnchorChange::kMoved);
  EXPECT_EQ(CompareAnchors(before, {At("a", 1.5), At("c", 2)}), AnchorChange::kAdded);
  EXPECT_EQ(CompareAnchors({}, before), AnchorChange::kAdded);
  graph::Anchor vaguer = At("b", 2);
  vaguer.covariance *= 2.0;
  EXPECT_EQ(CompareAnchors(before, {At("a", 1), vaguer}), AnchorChange::kMoved);
}

TEST(CheckNotRedundantTest, DependsOnTheChangeAndOnBothLinkPoints) {
  struct Case {
    std::string name;
    AnchorChange change = AnchorChange::kAdded;
    bool forced = false;
    bool suspended = false;
    bool other_forced = false;
    bool other_suspended = false;
    bool redundant = false;
  };
  const std::vector<Case> cases = {
      {"an added anchor", AnchorChange::kAdded, false, false, false, false, true},
      {"a moved anchor", AnchorChange::kMoved, false, false, false, false, true},
      {"no change of anchors", AnchorChange::kNone, false, false, false, false, false},
      {"forced", AnchorChange::kAdded, true, false, false, false, false},
      {"suspended", AnchorChange::kMoved, false, true, false, false, false},
      {"added beside a forced one", AnchorChange::kAdded, false, false, true, false, true},
      {"moved beside a forced one", AnchorChange::kMoved, false, false, true, false, false},
      {"beside a suspended one", AnchorChange::kAdded, false, false, false, true, false},
  };
  for (const Case& test : cases) {
    StoredLinkPoint changed = Join("new", {At("a", 0), At("b", 5)});
    changed.forced = test.forced;
    if (test.suspended) changed.point.use = graph::LinkPointUse::kSuspended;
    StoredLinkPoint other = Join("old", {At("b", 5.1), At("a", 0)});
    other.forced = test.other_forced;
    if (test.other_suspended) other.point.use = graph::LinkPointUse::kSuspended;
    EXPECT_CODE(CheckNotRedundant(changed, test.change, {other}),
                test.redundant ? absl::StatusCode::kAlreadyExists : absl::StatusCode::kOk)
        << test.name;
    // One that the optimisation has switched off stands in the way all the same.
    if (!test.other_suspended) other.point.use = graph::LinkPointUse::kSwitchedOff;
    EXPECT_EQ(CheckNotRedundant(changed, test.change, {other}).ok(), !test.redundant) << test.name;
  }
}

TEST(CheckNotRedundantTest, NamesTheNearestAndNeverItself) {
  const StoredLinkPoint changed = Join("new", {At("a", 0), At("b", 0)});
  const std::vector<StoredLinkPoint> others = {
      Join("new", {At("a", 0), At("b", 0)}), Join("far", {At("a", 5), At("b", 0)}),
      Join("near", {At("a", 0.25), At("b", 0)}), Join("nearest", {At("a", 0.125), At("b", 0)}),
      Join("candidate", {At("a", 0)})};
  EXPECT_STATUS(CheckNotRedundant(changed, AnchorChange::kAdded, others), absl::StatusCode::kAlreadyExists,
                AllOf(HasSubstr("sites/campus/linkPoints/new:"), HasSubstr("the same 2 maps"),
                      HasSubstr("sites/campus/linkPoints/nearest, 0.12 m apart"), HasSubstr("force")));
  EXPECT_OK(CheckNotRedundant(changed, AnchorChange::kAdded, {others[0], others[1], others[4]}));
  EXPECT_OK(CheckNotRedundant(Join("new", {At("a", 0)}), AnchorChange::kAdded, others)) << "a candidate joins nothing";
}

TEST(ApplyUpdateTest, KeepsWhatTheStoreSets) {
  StoredLinkPoint stored = Join("door", {At("a", 0), At("b", 0)});
  stored.point.use = graph::LinkPointUse::kSwitchedOff;
  stored.T_world_place = PoseWithCovariance{{1, 2, 3}, Eigen::Matrix3d::Identity()};
  stored.create_time = 77;
  StoredLinkPoint update = Join("door", {At("c", 1), At("b", 2)});
  update.point.tag = "new";
  update.point.use = graph::LinkPointUse::kSuspended;
  ASSERT_OK_AND_ASSIGN(const StoredLinkPoint changed, ApplyUpdate(stored, update, {}));
  EXPECT_EQ(changed.point.use, graph::LinkPointUse::kSwitchedOff) << "only SetSuspended and the optimisation change it";
  EXPECT_EQ(changed.T_world_place->pose, stored.T_world_place->pose);
  EXPECT_EQ(changed.create_time, 77);
  EXPECT_EQ(changed.point.tag, "new");
  EXPECT_THAT(MapsOf(changed), ElementsAre("b", "c"));
  EXPECT_EQ(changed.point.anchors[0].T_map_place.x, 2.0);
}

TEST(ApplyUpdateTest, WithoutForceTheStoredAnchorsMustFitToo) {
  const StoredLinkPoint other = Join("other", {At("a", 0), At("b", 0)});
  StoredLinkPoint stored = Join("door", {At("a", 0.1), At("b", 0)});
  stored.forced = true;
  StoredLinkPoint update = stored;
  update.forced = false;
  EXPECT_CODE(ApplyUpdate(stored, update, {other}), absl::StatusCode::kAlreadyExists);
  update.point.anchors = {At("a", 50), At("b", 50)};
  EXPECT_CODE(ApplyUpdate(stored, update, {other}), absl::StatusCode::kAlreadyExists)
      << "force is given up where the link point stands; it can be moved first";
  update.forced = true;
  EXPECT_OK(ApplyUpdate(stored, update, {other}));
}

TEST(ApplyAnchorTest, AppendsAndForces) {
  const StoredLinkPoint stored = Join("door", {At("a", 0)});
  const StoredLinkPoint other = Join("other", {At("a", 0), At("b", 0)});
  const NewAnchor added{LinkPointId("door"), 0, At("b", 0.1), false};
  EXPECT_STATUS(ApplyAnchor(stored, added, {other}), absl::StatusCode::kAlreadyExists, HasSubstr("linkPoints/other"));
  NewAnchor forced = added;
  forced.force = true;
  ASSERT_OK_AND_ASSIGN(const StoredLinkPoint changed, ApplyAnchor(stored, forced, {other}));
  EXPECT_TRUE(changed.forced);
  EXPECT_THAT(MapsOf(changed), ElementsAre("a", "b"));
  EXPECT_STATUS(ApplyAnchor(changed, forced, {}), absl::StatusCode::kAlreadyExists, HasSubstr("\"b\""))
      << "also by force a map has one anchor";
  ASSERT_OK_AND_ASSIGN(const StoredLinkPoint again,
                       ApplyAnchor(changed, {LinkPointId("door"), 0, At("c", 0), false}, {}));
  EXPECT_TRUE(again.forced) << "stays forced";
}

TEST(ApplySuspensionTest, OnlyAResumedLinkPointMustFit) {
  const StoredLinkPoint other = Join("other", {At("a", 0), At("b", 0)});
  StoredLinkPoint stored = Join("door", {At("a", 0.1), At("b", 0)});
  ASSERT_OK_AND_ASSIGN(const StoredLinkPoint suspended, ApplySuspension(stored, true, {other}));
  EXPECT_EQ(suspended.point.use, graph::LinkPointUse::kSuspended);
  EXPECT_CODE(ApplySuspension(suspended, false, {other}), absl::StatusCode::kAlreadyExists);
  ASSERT_OK_AND_ASSIGN(const StoredLinkPoint resumed, ApplySuspension(suspended, false, {}));
  EXPECT_EQ(resumed.point.use, graph::LinkPointUse::kUsed);
  stored.point.use = graph::LinkPointUse::kSwitchedOff;
  ASSERT_OK_AND_ASSIGN(const StoredLinkPoint used, ApplySuspension(stored, false, {other}));
  EXPECT_EQ(used.point.use, graph::LinkPointUse::kUsed) << "it was there all the time";
}

TEST(ValidateLinkPointTest, NamesTheAnchorAtFault) {
  struct Case {
    std::string message;  // empty: valid
    StoredLinkPoint link_point;
  };
  std::vector<Case> cases = {{"", Join("p", {At("a", 0), At("b", 0)})},
                             {"anchors are missing", Join("p", {})},
                             {"anchors[2]: the link point already has an anchor in the map \"a\"",
                              Join("p", {At("a", 0), At("b", 0), At("a", 1)})},
                             {"anchors[1].pose is not finite", Join("p", {At("a", 0), At("b", std::nan(""))})}};
  cases.push_back({"anchors[0]: the covariance is not symmetric", Join("p", {At("a", 0)})});
  cases.back().link_point.point.anchors[0].covariance(0, 1) = 0.5;
  cases.push_back({"anchors[0]: the covariance is not positive semi-definite", Join("p", {At("a", 0)})});
  cases.back().link_point.point.anchors[0].covariance(2, 2) = -0.5;
  cases.push_back({"anchors[0]: the covariance is not finite", Join("p", {At("a", 0)})});
  cases.back().link_point.point.anchors[0].covariance(2, 2) = INFINITY;
  cases.push_back({"direction is the map \"c\"", Join("p", {At("a", 0)})});
  cases.back().link_point.point.direction = MapId("c");
  cases.push_back({"", Join("p", {At("a", 0)})});
  cases.back().link_point.point.anchors[0].covariance.setZero();
  for (const Case& test : cases) {
    const absl::Status status = ValidateLinkPoint(test.link_point);
    EXPECT_EQ(status.ok(), test.message.empty()) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(test.message));
  }
}

TEST(ValidateQueryTest, RefusesAreasThatAreNone) {
  const auto circle = [](double x, double radius) {
    LinkPointQuery query;
    query.area = LinkPointCircle{{x, 0}, radius};
    return query;
  };
  EXPECT_OK(ValidateQuery(circle(0, 0)));
  EXPECT_OK(ValidateQuery(circle(0, INFINITY)));
  EXPECT_STATUS(ValidateQuery(circle(0, -0.1)), absl::StatusCode::kInvalidArgument, HasSubstr("radius"));
  EXPECT_STATUS(ValidateQuery(circle(0, NAN)), absl::StatusCode::kInvalidArgument, HasSubstr("radius"));
  EXPECT_STATUS(ValidateQuery(circle(INFINITY, 1)), absl::StatusCode::kInvalidArgument, HasSubstr("center"));
  LinkPointQuery polygon;
  polygon.area = std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}};
  EXPECT_STATUS(ValidateQuery(polygon), absl::StatusCode::kInvalidArgument, HasSubstr("2 corners"));
  polygon.area = std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}, {1, NAN}};
  EXPECT_STATUS(ValidateQuery(polygon), absl::StatusCode::kInvalidArgument, HasSubstr("not finite"));
  polygon.area = std::vector<Eigen::Vector2d>{{0, 0}, {1, 0}, {1, 1}};
  EXPECT_OK(ValidateQuery(polygon));
}

TEST(ValidateQueryTest, RefusesPolygonsOfMoreThanAThousandCorners) {
  const auto circle_of = [](int corners) {
    std::vector<Eigen::Vector2d> polygon;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * M_PI * i / corners;
      polygon.emplace_back(std::cos(angle), std::sin(angle));
    }
    LinkPointQuery query;
    query.area = std::move(polygon);
    return query;
  };
  EXPECT_OK(ValidateQuery(circle_of(1000)));
  EXPECT_STATUS(ValidateQuery(circle_of(1001)), absl::StatusCode::kInvalidArgument,
                HasSubstr("1001 corners: at most 1000 are allowed"));
}

}  // namespace
}  // namespace enfilade::storage

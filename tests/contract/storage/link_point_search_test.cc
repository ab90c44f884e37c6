// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_search.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

#include "tests/contract/storage/store_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class LinkPointSearchTest : public StoreTest {
 protected:
  LinkPointSearchTest() {
    storage::Map upstairs = MakeMap(site_, MapId("upstairs"), "Upstairs");
    upstairs.level = 2;
    EXPECT_OK(maps_.Create(Soon(), upstairs, ""));
    EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), ""));
  }
  void Create(const std::string& id, const std::vector<graph::Anchor>& anchors) {
    ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, id, anchors), ""));
  }
  std::vector<std::string> Find(const storage::LinkPointQuery& query) {
    const auto found = link_points_.Find(Soon(), site_, query);
    EXPECT_OK(found);
    std::vector<std::string> ids;
    for (const auto& link_point : found->link_points) ids.push_back(link_point.point.id.value());
    return ids;
  }
  static storage::LinkPointQuery Around(double x, double y, double radius) {
    storage::LinkPointQuery query;
    query.area = storage::LinkPointCircle{{x, y}, radius};
    return query;
  }
};

TEST_F(LinkPointSearchTest, FindsTheNearestFirst) {
  Create("far", {MakeAnchor("hall", 30, 0)});
  Create("near", {MakeAnchor("hall", 3, 0), MakeAnchor("lab", 0, 0)});
  Create("edge", {MakeAnchor("hall", 0, 20)});
  EXPECT_THAT(Find(Around(0, 0, 20)), ElementsAre("near", "edge"));
  EXPECT_THAT(Find(Around(0, 0, 19.99)), ElementsAre("near"));
  EXPECT_THAT(Find(Around(0, 0, kInfinity)), ElementsAre("near", "edge", "far"));
  storage::LinkPointQuery query = Around(0, 0, kInfinity);
  query.limit = 2;
  EXPECT_THAT(Find(query), ElementsAre("near", "edge"));
  query.candidate = true;
  EXPECT_THAT(Find(query), ElementsAre("edge", "far"));
  query.candidate = false;
  EXPECT_THAT(Find(query), ElementsAre("near"));
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("near"), 0, true));
  EXPECT_THAT(Find(query), IsEmpty());
  query.with_unused = true;
  EXPECT_THAT(Find(query), ElementsAre("near"));
}

TEST_F(LinkPointSearchTest, ALiftIsFoundOnItsLevelsAndOnNoneBetween) {
  Create("lift", {MakeAnchor("hall", 1, 0), MakeAnchor("upstairs", 0, 0)});
  Create("door", {MakeAnchor("hall", 2, 0), MakeAnchor("lab", 0, 0)});
  storage::LinkPointQuery query = Around(0, 0, 10);
  query.level = 0;
  EXPECT_THAT(Find(query), ElementsAre("lift", "door"));
  query.level = 1;
  EXPECT_THAT(Find(query), IsEmpty());
  query.level = 2;
  EXPECT_THAT(Find(query), ElementsAre("lift"));
  ASSERT_OK_AND_ASSIGN(storage::Map upstairs, maps_.Get(Soon(), site_, MapId("upstairs")));
  upstairs.level = 1;
  ASSERT_OK(maps_.Update(Soon(), upstairs));
  EXPECT_THAT(Find(query), IsEmpty());
  query.level = 1;
  EXPECT_THAT(Find(query), ElementsAre("lift"));
}

TEST_F(LinkPointSearchTest, FindsInsideAPolygonOnly) {
  Create("in", {MakeAnchor("hall", 1, 1)});
  Create("out", {MakeAnchor("hall", 3, 1)});
  storage::LinkPointQuery query;
  // An L whose notch holds "out".
  query.area = std::vector<Eigen::Vector2d>{{0, 0}, {4, 0}, {4, 0.5}, {2, 0.5}, {2, 4}, {0, 4}};
  EXPECT_THAT(Find(query), ElementsAre("in"));
  query.level = 2;
  EXPECT_THAT(Find(query), IsEmpty());
  query.area = std::vector<Eigen::Vector2d>{{0, 0}, {4, 0}};
  EXPECT_CODE(link_points_.Find(Soon(), site_, query), absl::StatusCode::kInvalidArgument);
  query.area = storage::LinkPointCircle{{0, 0}, -1.0};
  EXPECT_CODE(link_points_.Find(Soon(), site_, query), absl::StatusCode::kInvalidArgument);
  query.area = storage::LinkPointCircle{{std::nan(""), 0}, 1.0};
  EXPECT_CODE(link_points_.Find(Soon(), site_, query), absl::StatusCode::kInvalidArgument);
}

TEST_F(LinkPointSearchTest, PlacesFollowFromTheRootThroughLinkPoints) {
  const double quarter = std::numbers::pi / 2;
  // "lab" and "upstairs" hang together before either is joined to the hall.
  Create("stairs", {MakeAnchor("lab", 5, 0), MakeAnchor("upstairs", 1, 1)});
  Create("candidate", {MakeAnchor("upstairs", 3, 1)});
  EXPECT_THAT(Find(Around(0, 0, kInfinity)), IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto unplaced, link_points_.ListUnplaced(Soon(), site_, 10));
  EXPECT_EQ(unplaced.size(), 2U);
  Create("door", {MakeAnchor("hall", 10, 0, quarter), MakeAnchor("lab", 0, 0)});
  ASSERT_OK_AND_ASSIGN(const auto stairs, link_points_.Get(Soon(), site_, LinkPointId("stairs")));
  ASSERT_TRUE(stairs.T_world_place);
  EXPECT_THAT(stairs.T_world_place->pose, PoseNear(Pose2{10, 5, quarter}, 1e-9, 1e-9));
  ASSERT_OK_AND_ASSIGN(const auto candidate, link_points_.Get(Soon(), site_, LinkPointId("candidate")));
  ASSERT_TRUE(candidate.T_world_place);
  EXPECT_THAT(candidate.T_world_place->pose, PoseNear(Pose2{10, 7, quarter}, 1e-9, 1e-9));
  EXPECT_GT(candidate.T_world_place->covariance.trace(), stairs.T_world_place->covariance.trace());
  ASSERT_OK_AND_ASSIGN(const auto places, graph_.GetPlaces(Soon(), site_, {}));
  EXPECT_EQ(places.size(), 3U);
}

TEST_F(LinkPointSearchTest, TheIndexServesEverySearch) {
  // Written as the triggers would, which take their time over so many.
  database_.Sql(
      "SET session_replication_role = replica;"
      "INSERT INTO enfilade.link_points (site_id, link_point_id, kind, anchor_count, levels, position, yaw,"
      " world_covariance, changed_version) SELECT 'campus', 'p' || i, 1, 1, '{[0,1)}',"
      " ST_MakePoint(i % 200, i / 200), 0, array_fill(0.01::float8, '{9}'), 1 FROM generate_series(0, 39999) i;"
      "INSERT INTO enfilade.link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)"
      " SELECT 'campus', 'p' || i, 'hall', 1, i % 200, i / 200, 0, array_fill(0.01::float8, '{9}')"
      " FROM generate_series(0, 39999) i");
  database_.Sql("ANALYZE enfilade.link_points, enfilade.link_point_anchors");
  const auto plan = [&](const storage::postgres::Statement& statement, const std::string& types,
                        const std::string& values) {
    // The plan for any parameters, as a connection gets it in the long run.
    return database_.Sql("SET plan_cache_mode = force_generic_plan; PREPARE s (" + types + ") AS " + statement.sql +
                         "; EXPLAIN EXECUTE s (" + values + ")");
  };
  const std::string types = "text, int, int, smallint, bigint, float8, float8";
  const std::string values = "'campus', 1, 9, 1::smallint, 1000, 10, 10";
  const auto uses = [](const std::string& index) { return Contains(HasSubstr(index)); };
  EXPECT_THAT(plan(storage::postgres::kFindWithinOnLevel, types + ", float8, int", values + ", 3, 0"),
              uses("link_points_position_idx"));
  EXPECT_THAT(plan(storage::postgres::kFindWithin, types + ", float8", values + ", 3"), uses("link_points_world_idx"));
  EXPECT_THAT(plan(storage::postgres::kFindNearestOnLevel, types + ", int", values + ", 0"),
              uses("link_points_position_idx"));
  EXPECT_THAT(plan(storage::postgres::kFindNearest, types, values), uses("link_points_world_idx"));
  EXPECT_THAT(plan(storage::postgres::kFindWithin, types + ", float8", values + ", 3"),
              Not(Contains(HasSubstr("Seq Scan"))));

  storage::LinkPointQuery query = Around(50, 50, 1.0);
  query.level = 0;
  for (int i = 0; i < 8; ++i) EXPECT_EQ(Find(query).size(), 5U);
  query.area = storage::LinkPointCircle{{50.1, 50.2}, kInfinity};
  query.limit = 3;
  EXPECT_THAT(Find(query), ElementsAre("p10050", "p10250", "p10051"));
  pool_.reset();  // a connection's counts are published when it ends
  std::string scans = "0";
  for (int i = 0; i < 500 && scans == "0"; ++i) {
    // Where all are on one level the planner may take either.
    scans = database_.SqlValue(
        "SELECT sum(idx_scan) FROM pg_stat_user_indexes"
        " WHERE indexrelname IN ('link_points_position_idx', 'link_points_world_idx')");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(scans, "9") << "the stores' own statements take it too";
}

}  // namespace
}  // namespace enfilade::testing

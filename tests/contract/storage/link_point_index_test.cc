// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <limits>
#include <thread>

#include "storage/postgres/graph/link_point_search.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class LinkPointIndexTest : public StoreTest {
 protected:
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

TEST_F(LinkPointIndexTest, TheIndexServesEverySearch) {
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
  pool_.reset();  // a connection's last counts are published when it ends, earlier ones after a second
  std::string scans = "0";
  for (int i = 0; i < 3000 && scans != "9"; ++i) {
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

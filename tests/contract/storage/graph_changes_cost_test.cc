// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "fmt/format.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

class GraphChangesCostTest : public StoreTest {
 protected:
  // Maps and link points, each changed at a version from `first` to `last`. Written as the triggers would, which take
  // their time over so many.
  void Fill(const std::string& site, int first, int last) {
    constexpr int kCount = 5'000;
    const std::string version = fmt::format("{} + i % {}", first, last - first + 1);
    const auto insert = [&](const std::string& into, const std::string& values) {
      database_.Sql(
          fmt::format("SET session_replication_role = replica; INSERT INTO enfilade.{} SELECT '{}', {} FROM "
                      "generate_series(1, {}) i",
                      into, site, values, kCount));
    };
    insert("maps (site_id, map_id, display_name, environment)", "'m' || i, 'm' || i, 1");
    insert("graph_maps (site_id, map_id, changed_version, x, y, yaw, covariance)",
           "'m' || i, " + version + ", 0, 0, 0, array_fill(0.01::float8, '{9}')");
    insert("link_points (site_id, link_point_id, kind, anchor_count, changed_version)", "'p' || i, 1, 1, " + version);
    insert("link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)",
           "'p' || i, 'm' || i, 1, 0, 0, 0, array_fill(0.01::float8, '{9}')");
  }
  std::int64_t RowsRead() const {
    return std::stoll(
        database_.SqlValue("SELECT sum(coalesce(seq_tup_read, 0) + coalesce(idx_tup_fetch, 0))::bigint"
                           " FROM pg_stat_user_tables WHERE schemaname = 'enfilade'"));
  }
};

TEST_F(GraphChangesCostTest, ReadingOneChangeReadsFewRowsWhateverOtherSitesHaveChanged) {
  Fill("campus", 1, 1);
  ASSERT_OK(sites_.Create(Soon(), MakeSite(SiteId("busy"), "Busy"), ""));
  Fill("busy", 2, 1000);
  database_.Sql(
      "SET session_replication_role = replica; UPDATE enfilade.link_points SET changed_version = 3"
      " WHERE site_id = 'campus' AND link_point_id = 'p7';"
      "UPDATE enfilade.graph_maps SET changed_version = 3 WHERE site_id = 'campus' AND map_id = 'm7';"
      "UPDATE enfilade.site_graphs SET graph_version = 3 WHERE site_id = 'campus'");
  database_.Sql("ANALYZE");
  constexpr int kReads = 10;  // PostgreSQL plans for any parameters from the sixth on
  const std::int64_t before = RowsRead();
  {
    storage::postgres::PoolOptions options;
    options.url = database_.url();
    options.max_connections = 1;
    options.application_name = "reads-changes";
    auto pool = storage::postgres::Pool::Create(options);
    ASSERT_OK(pool);
    const storage::postgres::GraphStore graph(**pool);
    for (int i = 0; i < kReads; ++i) {
      const auto changes = graph.ReadChanges(Soon(), site_, 2);
      ASSERT_OK(changes);
      ASSERT_EQ(changes->link_points.size(), 1U);
      ASSERT_EQ(changes->maps.size(), 1U);
    }
  }
  // A connection hands in its statistics when it ends.
  while (database_.SqlValue("SELECT count(*) FROM pg_stat_activity WHERE application_name = 'reads-changes'") != "0") {
  }
  EXPECT_LE(RowsRead() - before, kReads * 20);
}

}  // namespace
}  // namespace enfilade::testing

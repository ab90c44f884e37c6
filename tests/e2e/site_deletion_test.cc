// SPDX-License-Identifier: Apache-2.0
// A large site is deleted while the server is killed (kill -9).
#include <gtest/gtest.h>

#include "enfilade/v1/site_service.grpc.pb.h"
#include "tests/e2e/whole_system.h"

namespace enfilade::testing {
namespace {

constexpr std::int64_t kRecords = 20'000;

class SiteDeletionTest : public ::testing::Test {
 protected:
  SiteDeletionTest() : system_({"listen.grace_s=2"}) {
    system_.CreateSite("s");
    system_.CreateSite("other");
    // Of a long day: twenty sessions.
    system_.Query(
        "WITH r AS (INSERT INTO robots (site_id, robot_id, display_name) VALUES ('s', 'r', 'R') RETURNING 1),"
        " s AS (INSERT INTO sessions (site_id, session_id, robot_id, state, finish_time)"
        "   SELECT 's', 's' || n, 'r', 3, now() FROM generate_series(1, 20) n RETURNING 1)"
        " SELECT (SELECT count(*) FROM r) + (SELECT count(*) FROM s)");
    system_.Query(
        "WITH i AS (INSERT INTO session_records (site_id, session_id, sequence, time_ns, kind, payload)"
        "   SELECT 's', 's' || (1 + n % 20), n, n, 2, '' FROM generate_series(1, " +
        std::to_string(kRecords) + ") n RETURNING 1) SELECT count(*) FROM i");
    // As if there were many more of them.
    system_.TryQuery(
        "CREATE FUNCTION slow() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN PERFORM pg_sleep(0.4); RETURN NULL; END "
        "$$");
    system_.TryQuery("CREATE TRIGGER slow AFTER DELETE ON session_records FOR EACH STATEMENT EXECUTE FUNCTION slow()");
  }

  std::int64_t Records() { return std::stoll(system_.Query("SELECT count(*) FROM session_records")); }

  WholeSystem system_;
};

TEST_F(SiteDeletionTest, GoesOnAfterEveryKillUntilTheSiteIsGone) {
  v1::DeleteSiteRequest request;
  request.set_name("sites/s");
  request.set_force(true);
  const auto deleted = system_.server().Connect().Call(&v1::SiteService::Stub::DeleteSite, request);
  ASSERT_TRUE(deleted.ok()) << deleted.status();
  for (int kill = 0; kill < 2; ++kill) {
    const std::int64_t before = Records();
    ASSERT_TRUE(Eventually([&] { return Records() < before; })) << "it does not go on after " << kill << " kills";
    system_.server().Kill();
    ASSERT_GT(Records(), 0) << "it was not killed in between";
    system_.server().StartAndWait();
  }
  ASSERT_TRUE(Eventually([&] { return system_.Query("SELECT count(*) FROM sites WHERE site_id = 's'") == "0"; }));
  EXPECT_EQ(Records(), 0);
  EXPECT_EQ(system_.Query("SELECT count(*) FROM sites"), "1");
}

}  // namespace
}  // namespace enfilade::testing

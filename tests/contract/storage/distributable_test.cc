// SPDX-License-Identifier: Apache-2.0
// What the database is like where it is sharded by site_id, as Citus does it (docs/database.md).
#include "core/base/resource_name.h"
#include "storage/postgres/driver/error.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/sessions/session_store.h"
#include "storage/sites/site_store.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/command.h"

namespace enfilade::testing {
namespace {

using storage::postgres::Params;
using storage::postgres::Statement;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class DistributableTest : public DatabaseTest {};

TEST_F(DistributableTest, EveryTableHasItsSiteAsPlainText) {
  EXPECT_THAT(database_.Sql("SELECT table_name FROM information_schema.columns WHERE table_schema = 'enfilade'"
                            " AND column_name = 'site_id'"
                            " AND (domain_name IS NOT NULL OR data_type <> 'text' OR collation_name <> 'C')"),
              IsEmpty());
}

TEST_F(DistributableTest, ASitesIdStillHasItsForm) {
  constexpr Statement kInsert{"inserting", "INSERT INTO enfilade.sites (site_id, display_name) VALUES ($1, 'A')"};
  EXPECT_CODE(storage::postgres::ExecuteAlone(*pool_, Soon(), kInsert, Params("Not an id")),
              absl::StatusCode::kInvalidArgument);
}

// With the names of constraints that a shard has.
class ShardTest : public StoreTest {
 protected:
  ShardTest() {
    database_.Sql(
        "DO $$ DECLARE c record; BEGIN FOR c IN SELECT conrelid::regclass AS t, conname FROM pg_constraint"
        " WHERE connamespace = 'enfilade'::regnamespace AND conrelid <> 0 AND contype IN ('p', 'u', 'f', 'c') LOOP"
        " EXECUTE format('ALTER TABLE %s RENAME CONSTRAINT %I TO %I', c.t, c.conname, c.conname || '_102041');"
        " END LOOP; END $$");
  }
};

TEST_F(ShardTest, ErrorsAreExplainedAsInOneDatabase) {
  const auto create = [&](const char* robot, const char* map) {
    return sessions_.Create(Soon(), MakeSession(site_, SessionId("first"), RobotId(robot), MapId(map)), "").status();
  };
  EXPECT_STATUS(create("nobody", "hall"), absl::StatusCode::kNotFound, HasSubstr("robots/nobody"));
  EXPECT_STATUS(create("r1", "nowhere"), absl::StatusCode::kNotFound, HasSubstr("maps/nowhere"));
  EXPECT_OK(create("r1", "hall"));
  EXPECT_STATUS(create("r1", "hall"), absl::StatusCode::kAlreadyExists, HasSubstr("sessions/first"));
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(site_, MapId("again"), "Hall"), ""), absl::StatusCode::kAlreadyExists,
                HasSubstr("Hall"));
}

// On a server that has Citus, which ENFILADE_TEST_DATABASE names: its tables are really distributed.
class DistributedTest : public DatabaseTest {
 protected:
  void SetUp() override {
    if (database_.SqlValue("SELECT count(*) FROM pg_available_extensions WHERE name = 'citus'") == "0") {
      GTEST_SKIP() << "the database server has no extension citus: tables are not distributed";
    }
    database_.Sql("CREATE EXTENSION citus");
    database_.Sql("SELECT citus_set_coordinator_host('localhost', current_setting('port')::integer)");
    database_.Sql(
        "SELECT citus_set_node_property('localhost', current_setting('port')::integer, 'shouldhaveshards',"
        " true)");
    const CommandResult run =
        RunCommand({"psql", "-X", "-q", "-f", ProjectFile("deploy/citus/distribute.sql"), database_.url()});
    ASSERT_EQ(run.exit_code, 0) << run.output;
    // New connections have the database's new settings.
    ASSERT_OK_AND_ASSIGN(pool_, storage::postgres::Pool::Create({.url = database_.url()}));
  }
};

TEST_F(DistributedTest, EveryTableIsDistributedAndWritersAreKnown) {
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM citus_tables WHERE citus_table_type = 'distributed'"
                               " AND distribution_column <> 'site_id'"),
            "0");
  storage::CallContext context = Soon();
  context.actor = "ann";
  const SiteId site("campus");
  ASSERT_OK(storage::SiteStore(*pool_).Create(context, MakeSite(site, "Campus"), "request"));
  ASSERT_OK(storage::SiteStore(*pool_).Create(context, MakeSite(site, "Campus"), "request"));
  const storage::postgres::GraphStore graph(*pool_);
  ASSERT_OK_AND_ASSIGN(const auto listener, graph.Listen(Soon()));
  ASSERT_OK(storage::postgres::MapStore(*pool_).Create(context, MakeMap(site, MapId("hall"), "Hall"), ""));
  ASSERT_OK(storage::postgres::MapStore(*pool_).Create(context, MakeMap(site, MapId("lab"), "Lab"), ""));
  ASSERT_OK(storage::postgres::LinkPointStore(*pool_).Create(
      context, MakeLinkPoint(site, "door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)}), ""));
  ASSERT_OK_AND_ASSIGN(const auto changes, listener->Await(Soon()));
  EXPECT_FALSE(changes.empty());
  ASSERT_OK_AND_ASSIGN(const auto versions, graph.ListVersions(Soon(), site, 0, 10));
  ASSERT_THAT(versions, SizeIs(3));
  for (const storage::GraphVersion& version : versions) EXPECT_EQ(version.actor, "ann");
  ASSERT_OK_AND_ASSIGN(const auto entries, storage::AuditStore(*pool_).List(Soon(), site, "", 0, 100));
  EXPECT_FALSE(entries.empty());
  for (const storage::AuditEntry& entry : entries) EXPECT_EQ(entry.actor, "ann");
}

}  // namespace
}  // namespace enfilade::testing

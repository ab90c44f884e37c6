// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <iterator>
#include <thread>

#include "storage/postgres/driver/transaction.h"
#include "storage/schema.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/command.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;

// Each change is deployed and reverted with rows in every table.
class FilledMigrationsTest : public ::testing::Test {
 protected:
  void Migrate(const std::string& command, std::string_view change) {
    const CommandResult result =
        RunCommand({ProjectFile("deploy/database/migrate"), command, database_.url(), std::string(change)});
    ASSERT_EQ(result.exit_code, 0) << command << ' ' << change << ":\n" << result.output;
  }
  void Fill() {
    std::ifstream file(ProjectFile("tests/contract/storage/filled_schema.sql"));
    database_.Sql(std::string(std::istreambuf_iterator<char>(file), {}));
    EXPECT_THAT(EmptyTables(), IsEmpty()) << "filled_schema.sql has no row for them";
  }
  std::vector<std::string> EmptyTables() const {
    return database_.Sql(
        "SELECT relname FROM pg_class WHERE relnamespace = 'enfilade'::regnamespace AND relkind = 'r'"
        " AND (xpath('/row/n/text()', query_to_xml(format('SELECT count(*) AS n FROM %s', oid::regclass), false, true,"
        "   '')))[1]::text = '0'");
  }
  std::vector<std::string> Columns() const {
    return database_.Sql(
        "SELECT format('%s %s %s %s', c.table_name, c.column_name, c.data_type, c.is_nullable)"
        " FROM information_schema.columns c WHERE table_schema = 'enfilade'"
        " UNION ALL SELECT format('%s %s', conrelid::regclass, pg_get_constraintdef(oid)) FROM pg_constraint"
        "   WHERE connamespace = 'enfilade'::regnamespace"
        " UNION ALL SELECT indexdef FROM pg_indexes WHERE schemaname = 'enfilade' ORDER BY 1");
  }
  // What robots recorded, and what was made of it.
  std::vector<std::string> Recorded() const {
    std::vector<std::string> rows;
    for (const std::string table : {"sessions", "session_records", "blobs", "slam_nodes", "trajectory_points"}) {
      if (database_.SqlValue("SELECT to_regclass('enfilade." + table + "')").empty()) continue;
      const std::string key = table == "blobs"        ? "sha256"
                              : table == "sessions"   ? "(session_id, acknowledged_sequence)"
                              : table == "slam_nodes" ? "node_id"
                                                      : "(session_id, sequence)";
      for (const std::string& row : database_.Sql("SELECT " + key + " FROM enfilade." + table)) {
        rows.push_back(table + ' ' + row);
      }
    }
    return rows;
  }

  TestDatabase database_{TestDatabase::Content::kEmpty};
};

TEST_F(FilledMigrationsTest, EachGoesForwardAndBackOverFilledTables) {
  const auto changes = storage::KnownChanges();
  ASSERT_NO_FATAL_FAILURE(Migrate("up", changes.front()));
  std::vector<std::vector<std::string>> columns = {Columns()};
  std::vector<std::vector<std::string>> recorded = {Recorded()};
  for (std::size_t i = 1; i < changes.size(); ++i) {
    SCOPED_TRACE(changes[i]);
    ASSERT_NO_FATAL_FAILURE(Migrate("up", changes[i]));
    EXPECT_THAT(Recorded(), IsSupersetOf(recorded.back()));
    columns.push_back(Columns());
    ASSERT_NO_FATAL_FAILURE(Fill());
    recorded.push_back(Recorded());
  }
  for (std::size_t i = changes.size() - 1; i > 0; --i) {
    SCOPED_TRACE(changes[i]);
    ASSERT_NO_FATAL_FAILURE(Migrate("down", changes[i - 1]));
    EXPECT_THAT(Columns(), ElementsAreArray(columns[i - 1]));
    EXPECT_THAT(Recorded(), IsSupersetOf(recorded[i - 1]));
    ASSERT_NO_FATAL_FAILURE(Fill());
  }
  ASSERT_NO_FATAL_FAILURE(Migrate("up", changes.back()));
  EXPECT_THAT(Columns(), ElementsAreArray(columns.back()));
}

TEST_F(FilledMigrationsTest, AllGoBackFromHeadOverFilledTables) {
  const auto changes = storage::KnownChanges();
  ASSERT_NO_FATAL_FAILURE(Migrate("up", changes.back()));
  ASSERT_NO_FATAL_FAILURE(Fill());
  ASSERT_NO_FATAL_FAILURE(Migrate("down", changes.front()));
  ASSERT_NO_FATAL_FAILURE(Migrate("up", changes.back()));
}

using storage::postgres::Params;
using storage::postgres::Statement;
using storage::postgres::Transaction;

constexpr Statement kWriteFirst{"writing",
                                "INSERT INTO enfilade.trajectory_points VALUES ('a', 'mapped', 2, 2, 0, 0, 0, 0)"};
constexpr Statement kWriteSecond{"writing",
                                 "INSERT INTO enfilade.trajectory_points VALUES ('a', 'mapped', 3, 3, 0, 0, 0, 0)"};
constexpr Statement kLimitWaiting{"writing", "SET LOCAL lock_timeout = '10s'"};

TEST_F(FilledMigrationsTest, AnIndexOnABigTableIsBuiltWhileOthersWrite) {
  ASSERT_NO_FATAL_FAILURE(Migrate("up", "retention_bound"));
  Fill();
  auto pool = storage::postgres::Pool::Create({.url = database_.url()});
  ASSERT_OK(pool);
  const auto context = storage::CallContext::WithTimeout(std::chrono::minutes(5));
  ASSERT_OK_AND_ASSIGN(Transaction before, Transaction::Begin(**pool, context));
  ASSERT_OK(before.Execute(kWriteFirst, Params()));
  std::thread migration([&] { Migrate("up", "trajectory_nodes"); });
  EXPECT_TRUE(Eventually([&] {
    return database_.SqlValue(
               "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database()"
               " AND query LIKE 'CREATE INDEX%' AND wait_event_type = 'Lock'") == "1";
  })) << "it waits for transactions that began before it";
  {
    ASSERT_OK_AND_ASSIGN(Transaction meanwhile, Transaction::Begin(**pool, context));
    meanwhile.Queue(kLimitWaiting, Params());
    EXPECT_OK(meanwhile.Execute(kWriteSecond, Params()));
    EXPECT_OK(meanwhile.Commit());
  }
  EXPECT_OK(before.Commit());
  migration.join();
  EXPECT_EQ(database_.SqlValue("SELECT indisvalid FROM pg_index"
                               " WHERE indexrelid = 'enfilade.trajectory_points_node_idx'::regclass"),
            "t");
}

TEST_F(FilledMigrationsTest, AnIndexWhoseBuildingBrokeOffIsBuiltAgain) {
  ASSERT_NO_FATAL_FAILURE(Migrate("up", "retention_bound"));
  Fill();
  database_.Sql("CREATE INDEX trajectory_points_node_idx ON enfilade.trajectory_points (site_id)");
  database_.Sql(
      "UPDATE pg_index SET indisvalid = false WHERE indexrelid = 'enfilade.trajectory_points_node_idx'::regclass");
  ASSERT_NO_FATAL_FAILURE(Migrate("up", "trajectory_nodes"));
  EXPECT_EQ(database_.SqlValue("SELECT indisvalid AND indnkeyatts = 3 FROM pg_index"
                               " WHERE indexrelid = 'enfilade.trajectory_points_node_idx'::regclass"),
            "t");
}

TEST_F(FilledMigrationsTest, AChangeThatGetsNoLockGivesUpAndCanBeRepeated) {
  ASSERT_NO_FATAL_FAILURE(Migrate("up", "session_surveys"));
  auto pool = storage::postgres::Pool::Create({.url = database_.url()});
  ASSERT_OK(pool);
  const auto context = storage::CallContext::WithTimeout(std::chrono::minutes(5));
  {
    ASSERT_OK_AND_ASSIGN(Transaction reader, Transaction::Begin(**pool, context));
    ASSERT_OK(reader.Execute(Statement{"reading", "SELECT count(*) FROM enfilade.session_leases"}, Params()));
    const CommandResult refused = RunCommand(
        {ProjectFile("deploy/database/migrate"), "up", database_.url(), "mapping_attempts"}, {"ENFILADE_LOCK_WAIT=1"});
    EXPECT_NE(refused.exit_code, 0);
    EXPECT_THAT(refused.output, HasSubstr("lock timeout"));
  }
  ASSERT_NO_FATAL_FAILURE(Migrate("up", "mapping_attempts"));
}

}  // namespace
}  // namespace enfilade::testing

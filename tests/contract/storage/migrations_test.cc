// SPDX-License-Identifier: Apache-2.0
#include <thread>

#include "storage/schema.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/command.h"

namespace enfilade::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

CommandResult Migrate(const std::string& command, const TestDatabase& database, const std::string& change = "") {
  std::vector<std::string> arguments = {ProjectFile("deploy/database/migrate"), command, database.url()};
  if (!change.empty()) arguments.push_back(change);
  return RunCommand(arguments);
}

// Everything of ours in the database, one line each.
std::vector<std::string> Objects(const TestDatabase& database) {
  return database.Sql(
      "SELECT format('%s %s: %s DEFAULT %s', table_name, column_name, data_type, column_default) FROM"
      " information_schema.columns WHERE table_schema = 'enfilade'"
      " UNION ALL SELECT pg_get_constraintdef(oid) || conname FROM pg_constraint"
      "   WHERE connamespace = to_regnamespace('enfilade')"
      " UNION ALL SELECT indexdef FROM pg_indexes WHERE schemaname = 'enfilade'"
      " UNION ALL SELECT 'sequence ' || sequence_name FROM information_schema.sequences"
      "   WHERE sequence_schema = 'enfilade'"
      " UNION ALL SELECT pg_get_functiondef(oid) FROM pg_proc WHERE pronamespace = to_regnamespace('enfilade')"
      " UNION ALL SELECT pg_get_triggerdef(t.oid) FROM pg_trigger t JOIN pg_class c ON c.oid = t.tgrelid"
      "   WHERE NOT t.tgisinternal AND c.relnamespace = to_regnamespace('enfilade')"
      " UNION ALL SELECT 'schema ' || nspname FROM pg_namespace WHERE nspname = 'enfilade' ORDER BY 1");
}

storage::SchemaState StateOf(const TestDatabase& database) {
  auto pool = storage::postgres::Pool::Create({.url = database.url()});
  EXPECT_OK(pool);
  const auto state = storage::CheckSchema(storage::CallContext::WithTimeout(std::chrono::seconds(60)), **pool);
  EXPECT_OK(state);
  return *state;
}

class MigrationsTest : public ::testing::Test {
 protected:
  TestDatabase database_{TestDatabase::Content::kEmpty};
};

TEST_F(MigrationsTest, GoFromEmptyToHeadAndBackAndToHeadAgain) {
  EXPECT_EQ(StateOf(database_).position, storage::SchemaState::Position::kEmpty);
  const CommandResult up = Migrate("up", database_);
  ASSERT_EQ(up.exit_code, 0) << up.output;
  const std::vector<std::string> head = Objects(database_);
  EXPECT_THAT(head, Contains(HasSubstr("maps_outline_idx")));
  EXPECT_EQ(StateOf(database_).position, storage::SchemaState::Position::kAtHead);

  const CommandResult again = Migrate("up", database_);
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(Objects(database_), ElementsAreArray(head));
  const CommandResult verified = Migrate("verify", database_);
  EXPECT_EQ(verified.exit_code, 0) << verified.output;

  const CommandResult down = Migrate("down", database_);
  ASSERT_EQ(down.exit_code, 0) << down.output;
  EXPECT_THAT(Objects(database_), IsEmpty());
  EXPECT_EQ(StateOf(database_).position, storage::SchemaState::Position::kEmpty);

  ASSERT_EQ(Migrate("up", database_).exit_code, 0);
  EXPECT_THAT(Objects(database_), ElementsAreArray(head));
}

TEST_F(MigrationsTest, EachGoesBackAloneOverADatabaseInUse) {
  ASSERT_EQ(Migrate("up", database_, "@HEAD^").exit_code, 0);
  const std::vector<std::string> before = Objects(database_);
  ASSERT_EQ(Migrate("up", database_).exit_code, 0);
  const std::vector<std::string> head = Objects(database_);
  EXPECT_NE(head, before);
  database_.Sql("INSERT INTO enfilade.sites (site_id, display_name) VALUES ('a', 'A')");
  const CommandResult down = Migrate("down", database_, "@HEAD^");
  ASSERT_EQ(down.exit_code, 0) << down.output;
  const storage::SchemaState behind = StateOf(database_);
  EXPECT_EQ(behind.position, storage::SchemaState::Position::kBehind);
  EXPECT_NE(behind.deployed, behind.expected);
  EXPECT_THAT(Objects(database_), ElementsAreArray(before));
  ASSERT_EQ(Migrate("up", database_).exit_code, 0);
  EXPECT_THAT(Objects(database_), ElementsAreArray(head));
  EXPECT_EQ(database_.SqlValue("SELECT display_name FROM enfilade.sites"), "A");
}

TEST_F(MigrationsTest, TwoAtOnceWaitForEachOther) {
  CommandResult first, second;
  std::thread other([&] { first = Migrate("up", database_); });
  second = Migrate("up", database_);
  other.join();
  EXPECT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(second.exit_code, 0) << second.output;
  EXPECT_EQ(StateOf(database_).position, storage::SchemaState::Position::kAtHead);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) = count(DISTINCT change) FROM sqitch.events"), "t");
}

TEST_F(MigrationsTest, SaysWhenTheDatabaseDoesNotAnswer) {
  const CommandResult up = RunCommand(
      {ProjectFile("deploy/database/migrate"), "up", "postgresql:///x?host=/nonexistent"}, {"ENFILADE_WAIT=0"});
  EXPECT_NE(up.exit_code, 0);
  EXPECT_THAT(up.output, HasSubstr("does not answer"));
}

// What the architecture asks of every table, so that the database can be sharded by site.
TEST(SchemaTest, EveryKeyBeginsWithTheSiteAndNoForeignKeyLeavesIt) {
  const TestDatabase database;
  EXPECT_THAT(database.Sql("SELECT conrelid::regclass || ': ' || pg_get_constraintdef(oid) FROM pg_constraint"
                           " WHERE connamespace = 'enfilade'::regnamespace AND contype IN ('p', 'u')"
                           " AND pg_get_constraintdef(oid) NOT LIKE '%(site_id%'"
                           // The request that creates a site knows none yet.
                           " AND conname NOT IN ('site_requests_pkey', 'schema_compatibility_pkey')"),
              IsEmpty());
  EXPECT_THAT(database.Sql("SELECT conrelid::regclass || ': ' || pg_get_constraintdef(oid) FROM pg_constraint"
                           " WHERE connamespace = 'enfilade'::regnamespace AND contype = 'f'"
                           " AND pg_get_constraintdef(oid) NOT LIKE 'FOREIGN KEY (site_id%REFERENCES %(site_id%'"),
              IsEmpty());
  EXPECT_THAT(database.Sql("SELECT table_name FROM information_schema.tables WHERE table_schema = 'enfilade'"
                           " EXCEPT SELECT table_name FROM information_schema.columns WHERE column_name = 'site_id'"
                           " EXCEPT SELECT 'schema_compatibility'"),
              IsEmpty());
}

// Deleting a referred row looks for those that refer to it.
TEST(SchemaTest, EveryForeignKeyToABlobHasAnIndex) {
  const TestDatabase database;
  EXPECT_THAT(
      database.Sql("SELECT conrelid::regclass FROM pg_constraint c WHERE contype = 'f'"
                   " AND confrelid = 'enfilade.blobs'::regclass AND NOT EXISTS (SELECT FROM pg_index i"
                   "   WHERE i.indrelid = c.conrelid AND i.indkey[0] = c.conkey[1] AND i.indkey[1] = c.conkey[2])"),
      IsEmpty());
}

TEST(SchemaTest, TheForeignKeyOfTrajectoriesToKeyframesHasAnIndex) {
  const TestDatabase database;
  EXPECT_THAT(database.Sql("SELECT indexdef FROM pg_indexes WHERE tablename = 'trajectory_points'"),
              Contains(HasSubstr("(site_id, session_id, node_id)")));
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "tests/support/newer_schema.h"

#include "storage/schema.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using Position = storage::SchemaState::Position;
using Changes = std::vector<std::string_view>;

// Programs of several versions look at one database.
class NewerSchemaTest : public DatabaseTest {
 protected:
  // This program's changes and those of later versions.
  static Changes ProgramWith(const Changes& later) {
    Changes known(storage::KnownChanges().begin(), storage::KnownChanges().end());
    known.insert(known.end(), later.begin(), later.end());
    return known;
  }
  static Changes ThisProgram() { return ProgramWith({}); }

  storage::SchemaState SeenBy(const Changes& program) {
    const auto state = storage::CheckSchema(Soon(), *pool_, program);
    EXPECT_OK(state);
    return *state;
  }
  void Deploy() {
    const CommandResult up = schema_.Migrate("up", database_);
    ASSERT_EQ(up.exit_code, 0) << up.output;
  }

  NewerSchema schema_;
};

TEST_F(NewerSchemaTest, ServesTheOlderAndTheNewerProgramIfItOnlyAdds) {
  schema_.Add("wing", "ALTER TABLE enfilade.maps ADD COLUMN wing text;", "ALTER TABLE enfilade.maps DROP COLUMN wing;",
              std::string(storage::KnownChanges().back()));
  EXPECT_EQ(SeenBy(ProgramWith({"wing"})).position, Position::kBehind);
  Deploy();
  const storage::SchemaState older = SeenBy(ThisProgram());
  EXPECT_EQ(older.position, Position::kAhead);
  EXPECT_EQ(older.deployed, "wing");
  EXPECT_EQ(older.expected, storage::KnownChanges().back());
  EXPECT_EQ(SeenBy(ProgramWith({"wing"})).position, Position::kAtHead);
}

TEST_F(NewerSchemaTest, RefusesProgramsThatLackWhatAChangeNeeds) {
  schema_.Add("wing", "ALTER TABLE enfilade.maps ADD COLUMN wing text;", "ALTER TABLE enfilade.maps DROP COLUMN wing;",
              std::string(storage::KnownChanges().back()));
  schema_.Add("wings_only", "UPDATE enfilade.maps SET wing = '' WHERE wing IS NULL;", "", "wing");
  Deploy();
  const storage::SchemaState older = SeenBy(ThisProgram());
  EXPECT_EQ(older.position, Position::kTooNew);
  EXPECT_EQ(older.deployed, "wings_only");
  EXPECT_EQ(older.breaking, "wings_only");
  EXPECT_EQ(older.required, "wing");
  EXPECT_EQ(SeenBy(ProgramWith({"wing"})).position, Position::kAhead);
  EXPECT_EQ(SeenBy(ProgramWith({"wing", "wings_only"})).position, Position::kAtHead);

  const CommandResult down = schema_.Migrate("down", database_, "wing");
  ASSERT_EQ(down.exit_code, 0) << down.output;
  EXPECT_EQ(SeenBy(ThisProgram()).position, Position::kAhead);
}

TEST_F(NewerSchemaTest, RefusesAllOlderProgramsIfAChangeSaysNothing) {
  schema_.Add("silent", "SELECT 1;", "", "");
  Deploy();
  const storage::SchemaState older = SeenBy(ThisProgram());
  EXPECT_EQ(older.position, Position::kTooNew);
  EXPECT_EQ(older.breaking, "silent");
  EXPECT_EQ(older.required, "silent");
}

TEST_F(NewerSchemaTest, LacksAnEarlierChangeWhateverComesAfterIt) {
  schema_.Add("wing", "SELECT 1;", "", std::string(storage::KnownChanges().back()));
  Deploy();
  database_.Sql("DELETE FROM sqitch.dependencies");
  database_.Sql("DELETE FROM sqitch.changes WHERE change = 'trajectory_nodes'");
  EXPECT_EQ(SeenBy(ThisProgram()).position, Position::kBehind);
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "tests/support/newer_schema.h"

#include "storage/schema.h"
#include "tests/rpc/server_test.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

// A running server whose database a newer version migrates.
class NewerSchemaServerTest : public ServerTest {
 protected:
  v1::GetServerStatusResponse Status() const {
    const auto status = Call(&v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest());
    EXPECT_OK(status);
    return status.value_or(v1::GetServerStatusResponse());
  }
  // Until it has looked at the schema and found `change`.
  bool SeesSchema(const std::string& change) const {
    return Eventually([&] { return Status().schema_version() == change; });
  }
  void Record(std::int64_t first) {
    TestStream stream(*connection_, session_);
    stream.Receive();
    stream.SendBatch(ScanRecords(first, 20));
    EXPECT_TRUE(stream.AwaitAcknowledged(first + 19));
  }

  NewerSchema schema_;
  std::string session_ = CreateSession(true);
};

// Every table has a further column and every statement still works.
constexpr char kWiden[] =
    "DO $$ DECLARE t regclass; BEGIN FOR t IN SELECT oid FROM pg_class"
    " WHERE relnamespace = 'enfilade'::regnamespace AND relkind = 'r' AND relname <> 'schema_compatibility' LOOP"
    " EXECUTE format('ALTER TABLE %s ADD COLUMN added_later integer NOT NULL DEFAULT 7', t); END LOOP; END $$;";

TEST_F(NewerSchemaServerTest, ServesWhatOnlyAddsAndRefusesWhatBreaks) {
  Record(1);
  schema_.Add("wider", kWiden, "", std::string(storage::KnownChanges().back()));
  ASSERT_EQ(schema_.Migrate("up", database_).exit_code, 0);
  ASSERT_TRUE(SeesSchema("wider"));
  EXPECT_TRUE(Status().ready()) << Status().not_ready_reason();
  Record(21);
  EXPECT_OK(FinishSession(session_, 40));
  AwaitState(session_, v1::Session::STATE_MAPPED);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.session_records WHERE added_later = 7"), "40");

  schema_.Add("narrower", "SELECT 1;", "", "wider");
  ASSERT_EQ(schema_.Migrate("up", database_).exit_code, 0);
  ASSERT_TRUE(SeesSchema("narrower"));
  EXPECT_FALSE(Status().ready());
  EXPECT_THAT(Status().not_ready_reason(), HasSubstr("change narrower needs a program that knows wider"));

  ASSERT_EQ(schema_.Migrate("down", database_, "wider").exit_code, 0);
  ASSERT_TRUE(SeesSchema("wider"));
  EXPECT_TRUE(Status().ready()) << Status().not_ready_reason();
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
// What the database is like where it is sharded by site_id, as Citus does it (docs/database.md).
#include "core/base/resource_name.h"
#include "storage/postgres/driver/error.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/sessions/session_store.h"
#include "storage/sites/site_store.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using storage::postgres::Params;
using storage::postgres::Statement;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

}  // namespace
}  // namespace enfilade::testing

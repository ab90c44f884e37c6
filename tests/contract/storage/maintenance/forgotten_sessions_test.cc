// SPDX-License-Identifier: Apache-2.0
// What is left of deleted sessions goes in the end, unless something refers to it.
#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::hours;
using std::chrono::seconds;

class ForgottenSessionsTest : public StoreTest {
 protected:
  SessionId SessionAfter(const std::string& id, const SessionId& previous) {
    storage::Session session = MakeSession(site_, SessionId(id), robot_, std::nullopt);
    session.entry.previous = previous;
    EXPECT_OK(sessions_.Create(Soon(), session, ""));
    return session.id;
  }
  // Deletes the session with all its other rows, as if `ago`.
  void Delete(const SessionId& session, seconds ago = seconds(0)) {
    ASSERT_OK(sessions_.Delete(Soon(), site_, session));
    ASSERT_OK(maintenance_.PurgeDeletedSessions(Soon(), 1000));
    database_.Sql("UPDATE enfilade.sessions SET delete_time = now() - interval '" + std::to_string(ago.count()) +
                  " s' WHERE session_id = '" + session.value() + "'");
  }
  std::int64_t Forget(seconds kept, std::int64_t limit = 1000) {
    const auto forgotten = maintenance_.ForgetDeletedSessions(Soon(), kept, limit);
    EXPECT_OK(forgotten);
    return forgotten.value_or(-1);
  }
  std::string Left() {
    return database_.SqlValue(
        "SELECT coalesce(string_agg(session_id, ' ' ORDER BY session_id), '') FROM"
        " enfilade.sessions");
  }

  storage::Maintenance maintenance_{*pool_};
};

TEST_F(ForgottenSessionsTest, AreRememberedForAWhile) {
  const SessionId recent = NewSession("recent");
  const SessionId old = NewSession("old");
  NewSession("there");
  Delete(recent, hours(1));
  Delete(old, hours(3));
  EXPECT_EQ(Forget(hours(2)), 1);
  EXPECT_EQ(Left(), "recent there");
  EXPECT_CODE(Append(recent, ScanRecords(1, 2)), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(Append(old, ScanRecords(1, 2)), absl::StatusCode::kNotFound);
  EXPECT_EQ(NewSession("old"), old) << "its id can be used again";
  EXPECT_EQ(Forget(hours(2)), 0);
}

TEST_F(ForgottenSessionsTest, OneWhoseRowsAreStillThereStays) {
  const SessionId session = NewSession("s");
  ASSERT_OK(Append(session, ScanRecords(1, 5)));
  ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  EXPECT_EQ(Forget(seconds(0)), 0);
  ASSERT_OK(maintenance_.PurgeDeletedSessions(Soon(), 1000));
  EXPECT_EQ(Forget(seconds(0)), 1);
}

TEST_F(ForgottenSessionsTest, TheOneBeforeALivingSessionStaysAndNoneBeforeThat) {
  const SessionId first = NewSession("s1");
  const SessionId second = SessionAfter("s2", first);
  const SessionId third = SessionAfter("s3", second);
  Delete(first);
  Delete(second);
  EXPECT_EQ(Forget(seconds(0)), 1);
  EXPECT_EQ(Left(), "s2 s3");
  Delete(third);
  EXPECT_EQ(Forget(seconds(0), 1), 1) << "in portions";
  EXPECT_EQ(Forget(seconds(0), 1), 1);
  EXPECT_EQ(Left(), "");
}

TEST_F(ForgottenSessionsTest, OneThatARevisionIsOfStaysAsLongAsThat) {
  const SessionId session = NewSession("s");
  const TestBlob tile("tile");
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kMapping;
  revision.session = session;
  revision.raster_header = "h";
  revision.geometry = {0.05, {}, 256, 256};
  revision.content_sha256 = tile.sha256();
  revision.tiles = {{{0, 0}, tile.sha256()}};
  ASSERT_OK(revisions_.Add(Soon(), site_, map_, revision, {tile.view()}));
  Delete(session);
  EXPECT_EQ(Forget(seconds(0)), 0);
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_EQ(Forget(seconds(0)), 1);
}

TEST_F(ForgottenSessionsTest, OneThatUndoingMayBringBackAReferenceToStays) {
  const SessionId session = NewSession("s");
  database_.Sql(
      "INSERT INTO enfilade.rearrangements (site_id, rearrangement_id, reason, version_before, version_after, "
      "create_time)"
      " VALUES ('campus', 'r', 'a room', 1, 2, now() - interval '1 hour')");
  Delete(session);
  EXPECT_EQ(Forget(seconds(0)), 0);
  ASSERT_OK(maintenance_.DeleteExpiredUndo(Soon(), seconds(60), 1000));
  EXPECT_EQ(Forget(seconds(0)), 1);
}

}  // namespace
}  // namespace enfilade::testing

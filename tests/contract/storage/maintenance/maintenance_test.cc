// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/maintenance.h"

#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

class MaintenanceTest : public StoreTest {
 protected:
  std::string CountIn(const std::string& table) { return database_.SqlValue("SELECT count(*) FROM enfilade." + table); }
  void SetRetention(std::optional<seconds> retention) {
    ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
    site.raw_retention = retention;
    ASSERT_OK(sites_.Update(Soon(), site));
  }
  // As if the session had finished an hour ago.
  void Age(const SessionId& session) {
    database_.Sql("UPDATE enfilade.sessions SET finish_time = now() - interval '1 hour' WHERE session_id = '" +
                  session.value() + "'");
  }
  std::int64_t DeleteExpired(std::int64_t limit = 1000) {
    const auto deleted = maintenance_.DeleteExpiredRecords(Soon(), limit);
    EXPECT_OK(deleted);
    return *deleted;
  }
  std::int64_t Collect(seconds grace) {
    const auto collected = maintenance_.CollectBlobs(Soon(), grace, 1000);
    EXPECT_OK(collected);
    return collected->deleted;
  }

  storage::Maintenance maintenance_{*pool_};
};

TEST_F(MaintenanceTest, PurgesDeletedSessionsInPortionsAndKeepsTheirIds) {
  const TestBlob image("image");
  const SessionId deleted = NewSession("s1");
  const SessionId kept = NewSession("s2");
  auto records = ScanRecords(1, 50);
  records.push_back(ImageRecord(51, image.ref()));
  ASSERT_OK(Append(deleted, records, {image.view()}));
  ASSERT_OK(Append(kept, ScanRecords(1, 5)));
  ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", seconds(60)));
  ASSERT_EQ(leased->session.id, deleted);
  slam::SlamDelta delta;
  delta.submaps = {{0, 1, {0, 0, 0}, false, ""}};
  delta.nodes.resize(20);
  delta.trajectory.resize(20);
  for (std::int64_t i = 0; i < 20; ++i) {
    delta.nodes[static_cast<std::size_t>(i)].id = i;
    delta.trajectory[static_cast<std::size_t>(i)].sequence = i + 1;
    delta.trajectory[static_cast<std::size_t>(i)].node = i;
  }
  delta.loop_closures.resize(1);
  storage::MappingStep step = StepOf(delta, "c", 50);
  ASSERT_OK(mapping_.Commit(Soon(), leased->lease, step));

  ASSERT_OK_AND_ASSIGN(const std::int64_t nothing, maintenance_.PurgeDeletedSessions(Soon(), 1000));
  EXPECT_EQ(nothing, 0);
  ASSERT_OK(sessions_.Delete(Soon(), site_, deleted));
  std::int64_t total = 0;
  for (std::int64_t count = 30; count == 30;) {
    ASSERT_OK_AND_ASSIGN(count, maintenance_.PurgeDeletedSessions(Soon(), 30));
    EXPECT_LE(count, 30);
    total += count;
  }
  // 51 records, 1 reference, 20 points, 1 closure, 20 nodes, 1 submap, 1 checkpoint, 1 lease, 1 place in
  // the queue.
  EXPECT_EQ(total, 97);
  for (const char* table : {"slam_submaps", "slam_nodes", "slam_closures", "trajectory_points", "mapping_checkpoints",
                            "session_leases", "session_record_blobs"}) {
    EXPECT_EQ(CountIn(table), "0") << table;
  }
  EXPECT_EQ(CountIn("session_records"), "5");
  EXPECT_EQ(database_.SqlValue("SELECT string_agg(session_id, ' ') FROM enfilade.mapping_work"), kept.value());
  EXPECT_CODE(Append(deleted, ScanRecords(52, 53)), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(sessions_.Create(Soon(), MakeSession(site_, deleted, robot_, map_), ""),
              absl::StatusCode::kAlreadyExists);
}

TEST_F(MaintenanceTest, DeletesRecordsPastTheSitesRetention) {
  const SessionId session = NewSession("s1", false);
  ASSERT_OK(Append(session, ScanRecords(1, 25)));
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 25));
  Age(session);
  EXPECT_EQ(DeleteExpired(), 0);  // no retention is set
  SetRetention(seconds(7200));
  EXPECT_EQ(DeleteExpired(), 0);
  SetRetention(seconds(1800));
  EXPECT_EQ(DeleteExpired(10), 10);
  EXPECT_STATUS(records_.Read(Soon(), site_, session, 1, 1000), absl::StatusCode::kFailedPrecondition,
                HasSubstr("retention"));
  EXPECT_EQ(DeleteExpired(10), 10);
  EXPECT_EQ(DeleteExpired(10), 5);
  EXPECT_EQ(DeleteExpired(10), 0);
  EXPECT_EQ(CountIn("session_records"), "0");
  ASSERT_OK_AND_ASSIGN(const storage::Session stored, sessions_.Get(Soon(), site_, session));
  EXPECT_TRUE(stored.records_deleted);
  EXPECT_EQ(stored.record_counts.laser_scans, 25);
  // What was acknowledged stays acknowledged.
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult again, Append(session, ScanRecords(20, 25)));
  EXPECT_EQ(again.duplicates, 6);
  EXPECT_EQ(CountIn("session_records"), "0");
  ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  ASSERT_OK(maintenance_.PurgeDeletedSessions(Soon(), 1000));
  EXPECT_EQ(database_.SqlValue("SELECT purged FROM enfilade.sessions"), "t");
}

TEST_F(MaintenanceTest, TheLongestRetentionIsWithinTheDatabasesTimes) {
  SetRetention(storage::kMaxRetention);
  EXPECT_EQ(DeleteExpired(), 0);
  ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
  site.raw_retention = storage::kMaxRetention + seconds(1);
  EXPECT_STATUS(sites_.Update(Soon(), site).status(), absl::StatusCode::kInvalidArgument,
                HasSubstr("sites_raw_retention_max"));
}

TEST_F(MaintenanceTest, AnErrorInOneSiteStopsNoOther) {
  SetRetention(seconds(1800));
  const SessionId session = NewSession("s1", false);
  ASSERT_OK(Append(session, ScanRecords(1, 25)));
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 25));
  Age(session);
  // A site before this one, in which nothing can be deleted.
  database_.Sql(
      "INSERT INTO enfilade.sites (site_id, display_name, raw_retention_s) VALUES ('0broken', 'B', 0);"
      "INSERT INTO enfilade.robots (site_id, robot_id, display_name) VALUES ('0broken', 'r', 'R');"
      "INSERT INTO enfilade.sessions (site_id, session_id, robot_id, state, finish_time)"
      " VALUES ('0broken', 's', 'r', 3, now() - interval '1 hour');"
      "CREATE FUNCTION enfilade.refuse() RETURNS trigger LANGUAGE plpgsql AS"
      " $$ BEGIN RAISE 'the site is broken'; END $$;"
      "CREATE TRIGGER refuse BEFORE UPDATE ON enfilade.sessions FOR EACH ROW WHEN (OLD.site_id = '0broken')"
      " EXECUTE FUNCTION enfilade.refuse()");
  EXPECT_EQ(DeleteExpired(10), 10);
  EXPECT_EQ(DeleteExpired(10), 10);
  EXPECT_STATUS(maintenance_.DeleteExpiredRecords(Soon(), 10).status(), absl::StatusCode::kInternal,
                HasSubstr("0broken"));
  EXPECT_EQ(CountIn("session_records"), "0");
}

TEST_F(MaintenanceTest, KeepsRecordsThatAreStillToBeMapped) {
  SetRetention(seconds(0));
  const SessionId recording = NewSession("s1");
  const SessionId waiting = NewSession("s2");
  ASSERT_OK(Append(recording, ScanRecords(1, 5)));
  ASSERT_OK(Append(waiting, ScanRecords(1, 5)));
  ASSERT_OK(sessions_.Finish(Soon(), site_, waiting, 5));
  Age(waiting);
  EXPECT_EQ(DeleteExpired(), 0);
  const slam::SlamDelta nothing;
  storage::MappingStep last = StepOf(nothing, "", 5);
  last.final_state = storage::SessionState::kMapped;
  while (true) {
    ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", seconds(60)));
    ASSERT_TRUE(leased);
    if (leased->session.id != waiting) continue;
    ASSERT_OK(mapping_.Commit(Soon(), leased->lease, last));
    break;
  }
  EXPECT_EQ(DeleteExpired(), 5);
}

TEST_F(MaintenanceTest, CollectsBlobsThatNothingRefersTo) {
  const TestBlob in_record("in a record");
  const TestBlob in_tile("in a tile");
  const TestBlob unused("unused");
  ASSERT_OK(blobs_.Put(Soon(), site_, {in_record.view(), in_tile.view(), unused.view()}));
  const SessionId session = NewSession("s1", false);
  ASSERT_OK(Append(session, {ImageRecord(1, in_record.ref())}));
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kImport;
  revision.content_sha256 = in_tile.sha256();
  revision.tiles = {{{0, 0}, in_tile.sha256()}};
  ASSERT_OK(revisions_.Add(Soon(), site_, map_, revision, {}));
  EXPECT_EQ(Collect(seconds(3600)), 0);
  EXPECT_EQ(Collect(seconds(0)), 1);
  EXPECT_CODE(blobs_.Get(Soon(), site_, unused.sha256()), absl::StatusCode::kNotFound);
  EXPECT_EQ(Collect(seconds(0)), 0);

  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, false));
  EXPECT_EQ(Collect(seconds(0)), 1);
  ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  EXPECT_EQ(Collect(seconds(0)), 0);
  ASSERT_OK(maintenance_.PurgeDeletedSessions(Soon(), 1000));
  EXPECT_EQ(Collect(seconds(0)), 1);
  EXPECT_EQ(CountIn("blobs"), "0");
}

TEST_F(MaintenanceTest, PuttingABlobAgainRenewsItsGrace) {
  const TestBlob blob("content");
  ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
  database_.Sql(
      "UPDATE enfilade.blobs SET put_time = now() - interval '2 hours';"
      "UPDATE enfilade.loose_blobs SET since = now() - interval '2 hours'");
  ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
  EXPECT_EQ(Collect(seconds(3600)), 0);
  database_.Sql(
      "UPDATE enfilade.blobs SET put_time = now() - interval '2 hours';"
      "UPDATE enfilade.loose_blobs SET since = now() - interval '2 hours'");
  EXPECT_EQ(Collect(seconds(3600)), 1);
}

}  // namespace
}  // namespace enfilade::testing

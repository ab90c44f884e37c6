// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/site_deletion.h"

#include <thread>

#include "storage/postgres/graph/site_lease_store.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Progress = storage::SiteDeletion::Progress;

class SiteDeletionTest : public StoreTest {
 protected:
  // A session with records, a revision, a link point: rows in many tables.
  void Fill() {
    const TestBlob blob("image");
    session_ = NewSession("s1");
    auto records = ScanRecords(1, 50);
    records.push_back(ImageRecord(51, blob.ref()));
    ASSERT_OK(Append(session_, records, {blob.view()}));
    storage::Session next = MakeSession(site_, SessionId("s2"), robot_, map_);
    next.entry.previous = session_;
    ASSERT_OK(sessions_.Create(Soon(), next, ""));
    storage::NewRevision revision;
    revision.source = storage::RevisionSource::kImport;
    revision.content_sha256 = blob.sha256();
    for (int column = 0; column < 30; ++column) revision.tiles.push_back({{0, column}, blob.sha256()});
    ASSERT_OK(revisions_.Add(Soon(), site_, map_, revision, {}));
    ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "door", {MakeAnchor("hall", 1, 0)}), ""));
  }
  void Mark() { ASSERT_OK(sites_.Delete(Soon(), site_, 0, true)); }
  storage::SiteDeletion::Portion DeletePortion(std::int64_t limit) {
    // Each by a store of its own, as after a restart.
    const auto portion = storage::SiteDeletion(*pool_).DeletePortion(Soon(), site_, limit);
    EXPECT_OK(portion);
    return portion.ok() ? *portion : storage::SiteDeletion::Portion{Progress::kTaken};
  }
  std::int64_t DeleteAll(std::int64_t limit) {
    std::int64_t rows = 0;
    for (auto portion = DeletePortion(limit);; portion = DeletePortion(limit)) {
      rows += portion.rows;
      if (portion.progress != Progress::kMore) return rows;
    }
  }
  // The tables with rows of the site, found in the catalogue so that a new table is not forgotten.
  std::vector<std::string> TablesWithRows() {
    std::vector<std::string> tables;
    for (const std::string& table : database_.Sql("SELECT table_name FROM information_schema.columns"
                                                  " WHERE table_schema = 'enfilade' AND column_name = 'site_id'"
                                                  " AND table_name <> 'audit_log'")) {  // which outlives its site
      if (database_.SqlValue("SELECT count(*) FROM enfilade." + table + " WHERE site_id = 'campus'") != "0") {
        tables.push_back(table);
      }
    }
    return tables;
  }

  storage::SiteDeletion deletion_{*pool_};
  storage::postgres::SiteLeaseStore site_leases_{*pool_, storage::SiteRight::kChange};
  SessionId session_;
};

TEST_F(SiteDeletionTest, GoesOnInSmallPortionsUntilNothingIsLeft) {
  Fill();
  EXPECT_EQ(DeletePortion(10).progress, Progress::kTaken) << "it is not deleted";
  Mark();
  std::int64_t rows = 0;
  while (true) {
    const auto portion = DeletePortion(10);
    ASSERT_LE(portion.rows, 10);
    ASSERT_NE(portion.progress, Progress::kTaken);
    rows += portion.rows;
    if (portion.progress == Progress::kDone) break;
    ASSERT_OK_AND_ASSIGN(const storage::Site site, sites_.Get(Soon(), site_));
    ASSERT_TRUE(site.deletion);
    EXPECT_EQ(site.deletion->deleted_rows, rows);
  }
  EXPECT_GT(rows, 81) << "51 records and 30 tiles, among others";
  EXPECT_THAT(TablesWithRows(), IsEmpty());
  EXPECT_CODE(sites_.Get(Soon(), site_).status(), absl::StatusCode::kNotFound);
  EXPECT_EQ(DeletePortion(10).progress, Progress::kTaken) << "it is gone";
}

TEST_F(SiteDeletionTest, NothingCanBeAddedAndNobodyWorksThereMeanwhile) {
  Fill();
  ASSERT_OK_AND_ASSIGN(const auto mapped, mapping_.Acquire(Soon(), "worker", std::chrono::seconds(60)));
  ASSERT_TRUE(mapped);
  ASSERT_OK_AND_ASSIGN(const auto judged, site_leases_.Acquire(Soon(), site_, "judge", std::chrono::seconds(60)));
  ASSERT_TRUE(judged);
  ASSERT_OK(graph_.ReadChanges(Soon(), site_, 0));
  Mark();
  const auto kRefused = absl::StatusCode::kFailedPrecondition;
  const auto kReason = HasSubstr("is being deleted");
  EXPECT_STATUS(robots_.Create(Soon(), MakeRobot(site_, RobotId("r2"), "R"), "").status(), kRefused, kReason);
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(site_, MapId("m2"), "M"), "").status(), kRefused, kReason);
  EXPECT_STATUS(sessions_.Create(Soon(), MakeSession(site_, SessionId("s3"), robot_, map_), "").status(), kRefused,
                kReason);
  EXPECT_STATUS(sites_.Create(Soon(), MakeSite(site_, "Again"), "").status(), kRefused, kReason);
  ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
  EXPECT_STATUS(sites_.Update(Soon(), site).status(), kRefused, kReason);
  EXPECT_CODE(graph_.ReadChanges(Soon(), site_, 0).status(), absl::StatusCode::kNotFound);

  DeletePortion(1000);
  EXPECT_STATUS(Append(session_, ScanRecords(52, 53)).status(), kRefused, HasSubstr("deleted"));
  const slam::SlamDelta nothing;
  EXPECT_CODE(mapping_.Commit(Soon(), mapped->lease, StepOf(nothing, "", 1)), absl::StatusCode::kAborted);
  EXPECT_CODE(site_leases_.Renew(Soon(), *judged, std::chrono::seconds(60)), absl::StatusCode::kAborted);
  ASSERT_OK_AND_ASSIGN(const auto again, site_leases_.Acquire(Soon(), site_, "judge", std::chrono::seconds(60)));
  EXPECT_FALSE(again);
}

TEST_F(SiteDeletionTest, ItsIdCanBeUsedAgainWhenItIsGone) {
  Fill();
  Mark();
  DeleteAll(1000);
  ASSERT_OK_AND_ASSIGN(const storage::Site again, sites_.Create(Soon(), MakeSite(site_, "Campus"), ""));
  EXPECT_FALSE(again.deletion);
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, map_, "Hall"), ""));
  EXPECT_NE(database_.SqlValue("SELECT count(*) FROM enfilade.audit_log"), "0");
}

TEST_F(SiteDeletionTest, MayBeAskedForAgainAndTellsWhoBeganIt) {
  storage::CallContext context = Soon();
  context.actor = "ada";
  ASSERT_OK_AND_ASSIGN(const storage::Site site, sites_.Get(Soon(), site_));
  ASSERT_OK_AND_ASSIGN(const storage::Site deleted, sites_.Delete(context, site_, site.etag, true));
  ASSERT_TRUE(deleted.deletion);
  EXPECT_EQ(deleted.deletion->actor, "ada");
  EXPECT_EQ(deleted.deletion->deleted_rows, 0);
  context.actor = "bob";
  ASSERT_OK_AND_ASSIGN(const storage::Site again, sites_.Delete(context, site_, site.etag, true));
  EXPECT_EQ(again.deletion->actor, "ada");
  ASSERT_OK_AND_ASSIGN(const auto sites, deletion_.List(Soon()));
  ASSERT_EQ(sites.size(), 1U);
  EXPECT_EQ(sites[0].id, site_);
  EXPECT_EQ(sites[0].actor, "ada");
}

TEST_F(SiteDeletionTest, ASecondProcessLeavesAPortionToTheFirst) {
  Mark();
  ASSERT_OK_AND_ASSIGN(auto first, storage::postgres::Transaction::Begin(*pool_, Soon()));
  ASSERT_OK(first.Execute({"test", "SELECT FROM enfilade.sites WHERE site_id = 'campus' FOR NO KEY UPDATE"},
                          storage::postgres::Params()));
  EXPECT_EQ(DeletePortion(10).progress, Progress::kTaken);
}

// As everybody else does. Otherwise this ends with a deadlock.
TEST_F(SiteDeletionTest, LocksLeasesBeforeSessions) {
  Fill();
  ASSERT_OK(mapping_.Acquire(Soon(), "worker", std::chrono::seconds(60)));
  ASSERT_OK_AND_ASSIGN(auto step, storage::postgres::Transaction::Begin(*pool_, Soon()));
  const storage::postgres::Params none;
  ASSERT_OK(step.Execute({"test", "SELECT FROM enfilade.session_leases WHERE site_id = 'campus' FOR UPDATE"}, none));
  std::thread deletion([this] { DeleteSite(site_); });
  EXPECT_TRUE(Eventually([&] { return database_.SqlValue("SELECT count(*) FROM pg_locks WHERE NOT granted") != "0"; }));
  EXPECT_OK(step.Execute({"test", "SELECT FROM enfilade.sessions WHERE site_id = 'campus' FOR UPDATE"}, none));
  EXPECT_OK(step.Commit());
  deletion.join();
  EXPECT_THAT(TablesWithRows(), IsEmpty());
}

// A writer that had begun before may store a row behind the step that deletes its kind.
TEST_F(SiteDeletionTest, BeginsAgainIfARowIsLeft) {
  Fill();
  Mark();
  while (database_.SqlValue("SELECT count(*) FROM enfilade.robots WHERE site_id = 'campus'") != "0")
    DeletePortion(1000);
  database_.Sql("INSERT INTO enfilade.site_graphs (site_id, cause, resource) VALUES ('campus', 1, '')");
  absl::Status refused;
  while (refused.ok()) refused = deletion_.DeletePortion(Soon(), site_, 1000).status();
  EXPECT_STATUS(refused, absl::StatusCode::kFailedPrecondition, HasSubstr("sites/campus"));
  DeleteAll(1000);
  EXPECT_THAT(TablesWithRows(), IsEmpty());
}

}  // namespace
}  // namespace enfilade::testing

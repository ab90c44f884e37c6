// SPDX-License-Identifier: Apache-2.0
// What a site's retentions delete, and what they keep.
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::hours;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RetentionTest : public StoreTest {
 protected:
  void Keep(const std::function<void(storage::Site&)>& set) {
    ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
    set(site);
    ASSERT_OK(sites_.Update(Soon(), site));
  }
  void KeepRevisions(int newest, std::optional<seconds> age = {}) {
    Keep([&](storage::Site& site) { site.revision_retention = storage::RevisionRetention{newest, age}; });
  }
  // An import of one tile that no other revision has, or a session's layer that is a whole revision.
  void AddRevision(const MapId& map, std::optional<SessionId> session = std::nullopt) {
    const TestBlob tile("tile " + std::to_string(++tiles_));
    storage::NewRevision revision;
    revision.source = session ? storage::RevisionSource::kMapping : storage::RevisionSource::kImport;
    revision.session = std::move(session);
    revision.raster_header = "h";
    revision.geometry = {0.05, {}, 256, 256};
    revision.content_sha256 = tile.sha256();
    revision.tiles = {{{0, 0}, tile.sha256()}};
    ASSERT_OK(revisions_.Add(Soon(), site_, map, revision, {tile.view()}));
  }
  std::vector<std::int64_t> Revisions(const MapId& map) {
    std::vector<std::int64_t> numbers;
    const auto revisions = revisions_.List(Soon(), site_, map, 0, 1000);
    EXPECT_OK(revisions);
    for (const storage::MapRevision& revision : *revisions) numbers.push_back(revision.number);
    return numbers;
  }
  void Age(const std::string& table, const std::string& where, seconds age, const std::string& column = "create_time") {
    database_.Sql("UPDATE enfilade." + table + " SET " + column + " = now() - interval '" +
                  std::to_string(age.count()) + " s' WHERE " + where);
  }
  storage::MaintenancePortion DeleteRevisions(std::int64_t limit = 1000) {
    const auto portion = maintenance_.DeleteRevisions(Soon(), limit);
    EXPECT_OK(portion);
    return portion.value_or(storage::MaintenancePortion());
  }
  // The error of a statement; empty if it succeeds.
  std::string ErrorOf(const std::string& sql) {
    database_.Sql(
        "CREATE OR REPLACE FUNCTION error_of(statement text) RETURNS text LANGUAGE plpgsql AS $$ BEGIN"
        " EXECUTE statement; RETURN ''; EXCEPTION WHEN OTHERS THEN RETURN SQLERRM; END $$");
    return database_.SqlValue("SELECT error_of($$" + sql + "$$)");
  }
  std::int64_t DeleteHistory(std::int64_t limit = 1000) {
    const auto deleted = maintenance_.DeleteGraphHistory(Soon(), limit);
    EXPECT_OK(deleted);
    return deleted.value_or(0);
  }

  storage::Maintenance maintenance_{*pool_};
  int tiles_ = 0;
};

TEST_F(RetentionTest, AllRevisionsAreKeptUnlessTheSiteSaysOtherwise) {
  for (int i = 0; i < 5; ++i) AddRevision(map_);
  EXPECT_EQ(DeleteRevisions().deleted, 0);
  EXPECT_THAT(Revisions(map_), ElementsAre(5, 4, 3, 2, 1));
}

TEST_F(RetentionTest, KeepsTheNewestRevisionsThoseWithATagAndLayers) {
  const SessionId session = NewSession("s1");
  AddRevision(map_);
  AddRevision(map_, session);  // on top of the import, as a layer of its own
  for (int i = 0; i < 5; ++i) AddRevision(map_);
  AddRevision(map_, session);
  ASSERT_OK_AND_ASSIGN(const storage::MapRevision tagged, revisions_.Tag(Soon(), site_, map_, 3, "before the fire"));
  EXPECT_EQ(tagged.tag, "before the fire");
  // The last import and the session lie on each other.
  EXPECT_EQ(database_.SqlValue("SELECT string_agg(revision::text, ',' ORDER BY revision) FROM enfilade.map_layers"),
            "7,8");
  KeepRevisions(1);
  EXPECT_EQ(DeleteRevisions().deleted, 2 * 5) << "with a tile each";
  EXPECT_THAT(Revisions(map_), ElementsAre(8, 7, 3));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.map_revision_tiles"), "3");
  EXPECT_CODE(revisions_.Tag(Soon(), site_, map_, 2, "gone"), absl::StatusCode::kNotFound);
  ASSERT_OK(revisions_.Tag(Soon(), site_, map_, 3, ""));
  EXPECT_EQ(DeleteRevisions().deleted, 2);
  EXPECT_THAT(Revisions(map_), ElementsAre(8, 7));
}

TEST_F(RetentionTest, ARevisionGoesWhenItIsOldEnough) {
  for (int i = 0; i < 4; ++i) AddRevision(map_);
  KeepRevisions(1, hours(1));
  EXPECT_EQ(DeleteRevisions().deleted, 0);
  EXPECT_EQ(DeleteRevisions().looked_at, 0) << "nothing is due";
  Age("map_revisions", "revision <= 2", hours(2));
  Age("revision_reviews", "true", seconds(1), "due_time");  // as when an hour has passed
  EXPECT_EQ(DeleteRevisions().deleted, 4);
  EXPECT_THAT(Revisions(map_), ElementsAre(4, 3));
  // The next look is when revision 3 is an hour old.
  EXPECT_EQ(database_.SqlValue("SELECT r.due_time = v.create_time + interval '1 hour' FROM enfilade.revision_reviews r,"
                               " enfilade.map_revisions v WHERE v.revision = 3"),
            "t");
  KeepRevisions(1, seconds(0));
  EXPECT_EQ(DeleteRevisions().deleted, 2) << "another retention counts at once";
}

TEST_F(RetentionTest, MapsThatDoNotChangeAreNotLookedAt) {
  for (int i = 0; i < 30; ++i) {
    const MapId map("m" + std::to_string(i));
    ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, map, map.value()), ""));
    AddRevision(map);
    AddRevision(map);
  }
  KeepRevisions(1);
  EXPECT_EQ(DeleteRevisions(10).deleted, 10) << "in portions";
  while (DeleteRevisions(10).deleted > 0) {
  }
  EXPECT_EQ(DeleteRevisions().looked_at, 0);
  AddRevision(MapId("m7"));
  const storage::MaintenancePortion portion = DeleteRevisions();
  EXPECT_EQ(portion.looked_at, 1);
  EXPECT_EQ(portion.deleted, 2);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.map_revisions"), "30");
}

TEST_F(RetentionTest, BlobsOfDeletedRevisionsAreCollected) {
  for (int i = 0; i < 3; ++i) AddRevision(map_);
  KeepRevisions(1);
  EXPECT_EQ(DeleteRevisions().deleted, 4);
  ASSERT_OK_AND_ASSIGN(const storage::MaintenancePortion blobs, maintenance_.CollectBlobs(Soon(), seconds(0), 1000));
  EXPECT_EQ(blobs.deleted, 2);
}

TEST_F(RetentionTest, ALayersRevisionCannotBeDeleted) {
  AddRevision(map_);
  EXPECT_THAT(ErrorOf("DELETE FROM enfilade.map_revisions"), HasSubstr("map_layers_revision_fkey"));
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.map_layers"), "0") << "with its map it can";
}

TEST_F(RetentionTest, TheGraphForgetsWhatWasRemovedLongAgo) {
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("gone"), "Gone"), ""));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("later"), "Later"), ""));
  ASSERT_OK_AND_ASSIGN(const std::int64_t before, graph_.GetVersion(Soon(), site_));
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("gone"), 0, true));
  ASSERT_OK_AND_ASSIGN(const std::int64_t forgotten, graph_.GetVersion(Soon(), site_));
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("later"), 0, true));
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges changes, graph_.ReadChanges(Soon(), site_, before));
  EXPECT_THAT(changes.removed_maps, ElementsAre(MapId("gone"), MapId("later")));
  EXPECT_EQ(DeleteHistory(), 0);
  Keep([](storage::Site& site) { site.history_retention = hours(24); });
  EXPECT_EQ(DeleteHistory(), 0);
  Age("graph_versions", "version <= " + std::to_string(forgotten), hours(25));
  EXPECT_EQ(DeleteHistory(), forgotten + 1) << "versions, and a removal";
  ASSERT_OK_AND_ASSIGN(const auto versions, graph_.ListVersions(Soon(), site_, 0, 100));
  EXPECT_EQ(versions.back().version, forgotten + 1);
  // Who does not know of the removal reads everything again.
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges all, graph_.ReadChanges(Soon(), site_, before));
  EXPECT_TRUE(all.complete);
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges rest, graph_.ReadChanges(Soon(), site_, forgotten));
  EXPECT_FALSE(rest.complete);
  EXPECT_THAT(rest.removed_maps, ElementsAre(MapId("later")));
}

TEST_F(RetentionTest, TheGraphKeepsItsVersionAndTheLastOptimisations) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.GetVersion(Soon(), site_));
    storage::GraphSolution solution;
    solution.maps = {{map_, {{1.0 * i, 0, 0}, Eigen::Matrix3d::Identity()}}};
    ASSERT_OK(graph_.Apply(Soon(), site_, version, solution));
  }
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("new"), "New"), ""));
  Age("graph_versions", "true", hours(25));
  Keep([](storage::Site& site) { site.history_retention = hours(24); });
  DeleteHistory(1);
  while (DeleteHistory(1) > 0) {
  }
  ASSERT_OK_AND_ASSIGN(const auto versions, graph_.ListVersions(Soon(), site_, 0, 100));
  ASSERT_EQ(versions.size(), 4U);
  EXPECT_EQ(versions[0].resource, "maps/new");
  ASSERT_OK_AND_ASSIGN(const auto poses, graph_.GetMapPoses(Soon(), site_, versions[3].version, 0));
  EXPECT_EQ(poses.posed.at(0).T_world_map.pose.x, 0.0);
}

TEST_F(RetentionTest, AuditEntriesAreDeletedByTheirRetentionOnly) {
  const std::string count = "SELECT count(*) FROM enfilade.audit_log WHERE time < now() - interval '1 day'";
  EXPECT_THAT(ErrorOf("DELETE FROM enfilade.audit_log"), HasSubstr("the audit trail is never changed"));
  EXPECT_THAT(ErrorOf("UPDATE enfilade.audit_log SET actor = 'me'"), HasSubstr("never changed"));
  EXPECT_THAT(ErrorOf("TRUNCATE enfilade.audit_log"), HasSubstr("never changed"));
  database_.Sql(
      "INSERT INTO enfilade.audit_log (site_id, time, actor, action, resource, after)"
      " SELECT 'campus', now() - interval '2 days', 'ada', 1, 'maps/' || i, '{}' FROM generate_series(1, 25) i");
  database_.Sql(
      "INSERT INTO enfilade.audit_log (site_id, audit_id, time, actor, action, resource, after)"
      " SELECT 'other', i, now() - interval '2 days', 'ada', 1, 'maps/' || i, '{}'"
      " FROM generate_series(1, 5) i");
  EXPECT_EQ(*maintenance_.DeleteAuditEntries(Soon(), 10), 0);
  Keep([](storage::Site& site) { site.audit_retention = hours(24); });
  std::int64_t total = 0;
  for (std::int64_t deleted = 1; deleted > 0; total += deleted) {
    ASSERT_OK_AND_ASSIGN(deleted, maintenance_.DeleteAuditEntries(Soon(), 1000));
  }
  EXPECT_EQ(total, 25);
  EXPECT_EQ(database_.SqlValue(count), "5") << "of the other site, which keeps them";
  ASSERT_OK_AND_ASSIGN(const auto entries, audit_.List(Soon(), site_, "", 0, 1000));
  EXPECT_FALSE(entries.empty());
}

TEST_F(RetentionTest, FinishedSessionsAreDeletedAndTheirMapsStay) {
  const SessionId old = NewSession("old", false);
  const SessionId recent = NewSession("recent", false);
  const SessionId recording = NewSession("recording", false);
  for (const SessionId& session : {old, recent}) {
    ASSERT_OK(Append(session, ScanRecords(1, 5)));
    ASSERT_OK(sessions_.Finish(Soon(), site_, session, 5));
  }
  Age("sessions", "session_id = 'old'", hours(2), "finish_time");
  Age("sessions", "session_id = 'recording'", hours(2), "create_time");
  EXPECT_EQ(*maintenance_.DeleteFinishedSessions(Soon(), 100), 0);
  Keep([](storage::Site& site) { site.session_retention = hours(1); });
  EXPECT_EQ(*maintenance_.DeleteFinishedSessions(Soon(), 100), 1);
  EXPECT_EQ(
      database_.SqlValue("SELECT string_agg(session_id, ',') FROM enfilade.sessions WHERE delete_time IS NOT NULL"),
      "old");
  ASSERT_OK_AND_ASSIGN(const std::int64_t purged, maintenance_.PurgeDeletedSessions(Soon(), 100));
  EXPECT_GE(purged, 5);
  ASSERT_OK_AND_ASSIGN(const auto trail, audit_.List(Soon(), site_, "sessions/old", 0, 10));
  EXPECT_EQ(trail.front().action, storage::AuditAction::kDeleted);
}

TEST_F(RetentionTest, RetentionsAreReadBackAndBounded) {
  Keep([](storage::Site& site) {
    site.session_retention = hours(1);
    site.revision_retention = storage::RevisionRetention{3, hours(2)};
    site.history_retention = hours(3);
    site.audit_retention = storage::kMaxRetention;
  });
  ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
  EXPECT_EQ(site.session_retention, hours(1));
  ASSERT_TRUE(site.revision_retention);
  EXPECT_EQ(site.revision_retention->newest, 3);
  EXPECT_EQ(site.revision_retention->age, hours(2));
  EXPECT_EQ(site.history_retention, hours(3));
  EXPECT_EQ(site.audit_retention, storage::kMaxRetention);
  site.audit_retention = storage::kMaxRetention + seconds(1);
  EXPECT_STATUS(sites_.Update(Soon(), site).status(), absl::StatusCode::kInvalidArgument,
                HasSubstr("sites_retentions_check"));
  Keep([](storage::Site& s) { s.revision_retention.reset(); });
  ASSERT_OK_AND_ASSIGN(site, sites_.Get(Soon(), site_));
  EXPECT_FALSE(site.revision_retention);
}

}  // namespace
}  // namespace enfilade::testing

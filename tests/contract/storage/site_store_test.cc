// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/site_store.h"

#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SiteStoreTest : public StoreTest {
 protected:
  std::vector<std::string> ListIds(const storage::PageRequest& page) {
    const auto sites = sites_.List(Soon(), page);
    EXPECT_OK(sites);
    std::vector<std::string> ids;
    for (const storage::Site& site : *sites) ids.push_back(site.id.value());
    return ids;
  }
};

TEST_F(SiteStoreTest, GivesBackWhatWasStored) {
  storage::Site site = MakeSite(SiteId("north"), "N\xc3\xb6rdlich: \"a/b\"; DROP TABLE sites --'");
  site.raw_retention = std::chrono::hours(24);
  ASSERT_OK_AND_ASSIGN(const storage::Site created, sites_.Create(Soon(), site, ""));
  ASSERT_OK_AND_ASSIGN(const storage::Site stored, sites_.Get(Soon(), site.id));
  for (const storage::Site& read : {created, stored}) {
    EXPECT_EQ(read.id, site.id);
    EXPECT_EQ(read.display_name, site.display_name);
    EXPECT_EQ(read.raw_retention, std::chrono::hours(24));
    EXPECT_EQ(read.etag, created.etag);
    EXPECT_EQ(read.create_time, created.create_time);
  }
  EXPECT_NEAR(ToSeconds(created.create_time -
                        std::stoll(database_.SqlValue("SELECT extract(epoch FROM now())::bigint")) * kNsPerSecond),
              0.0, 60.0);
}

TEST_F(SiteStoreTest, RefusesWhatTheSchemaForbids) {
  EXPECT_CODE(sites_.Create(Soon(), MakeSite(SiteId("Bad Id"), "x"), ""), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(sites_.Create(Soon(), MakeSite(SiteId("a"), ""), ""), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(sites_.Create(Soon(), MakeSite(SiteId("a"), std::string(201, 'x')), ""),
              absl::StatusCode::kInvalidArgument);
  EXPECT_OK(sites_.Create(Soon(), MakeSite(SiteId("a"), std::string(200, 'x')), ""));
  storage::Site negative = MakeSite(SiteId("b"), "x");
  negative.raw_retention = std::chrono::seconds(-1);
  EXPECT_CODE(sites_.Create(Soon(), negative, ""), absl::StatusCode::kInvalidArgument);
}

TEST_F(SiteStoreTest, CreatesOncePerRequestId) {
  ASSERT_OK_AND_ASSIGN(const storage::Site first, sites_.Create(Soon(), MakeSite(SiteId("s1"), "x"), "request"));
  // The server has made another id for the repeated call.
  ASSERT_OK_AND_ASSIGN(const storage::Site repeated, sites_.Create(Soon(), MakeSite(SiteId("s2"), "x"), "request"));
  EXPECT_EQ(repeated.id, first.id);
  EXPECT_STATUS(sites_.Create(Soon(), MakeSite(SiteId("s1"), "x"), "another"), absl::StatusCode::kAlreadyExists,
                HasSubstr("sites/s1"));
  EXPECT_CODE(sites_.Create(Soon(), MakeSite(SiteId("s1"), "x"), ""), absl::StatusCode::kAlreadyExists);
}

TEST_F(SiteStoreTest, ARequestIdThatWasUsedForSomethingElseIsRefused) {
  const storage::RequestId request("request", std::string(32, 'a'));
  const storage::RequestId other("request", std::string(32, 'b'));
  ASSERT_OK_AND_ASSIGN(const storage::Site first, sites_.Create(Soon(), MakeSite(SiteId("s1"), "x"), request));
  ASSERT_OK_AND_ASSIGN(const storage::Site again, sites_.Create(Soon(), MakeSite(SiteId("s2"), "x"), request));
  EXPECT_EQ(again.id, first.id);
  EXPECT_STATUS(sites_.Create(Soon(), MakeSite(SiteId("s2"), "y"), other), absl::StatusCode::kInvalidArgument,
                HasSubstr("request_id"));
  EXPECT_CODE(robots_.Create(Soon(), MakeRobot(site_, RobotId("a"), "A"), request).status(), absl::StatusCode::kOk);
  EXPECT_CODE(robots_.Create(Soon(), MakeRobot(site_, RobotId("b"), "B"), other).status(),
              absl::StatusCode::kInvalidArgument);
}

TEST_F(SiteStoreTest, ListsInPages) {
  for (const char* id : {"b", "a", "d", "c"}) ASSERT_OK(sites_.Create(Soon(), MakeSite(SiteId(id), "x"), ""));
  EXPECT_THAT(ListIds({2, ""}), ElementsAre("a", "b"));
  EXPECT_THAT(ListIds({2, "b"}), ElementsAre("c", "campus"));
  EXPECT_THAT(ListIds({2, "campus"}), ElementsAre("d"));
  EXPECT_THAT(ListIds({2, "d"}), IsEmpty());
}

TEST_F(SiteStoreTest, UpdatesOnlyUnderTheStoredEtag) {
  ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
  site.display_name = "New";
  site.raw_retention = std::chrono::seconds(1);
  ASSERT_OK_AND_ASSIGN(const storage::Site updated, sites_.Update(Soon(), site));
  EXPECT_EQ(updated.display_name, "New");
  EXPECT_GT(updated.etag, site.etag);
  EXPECT_STATUS(sites_.Update(Soon(), site), absl::StatusCode::kAborted, HasSubstr("sites/campus"));
  site.id = SiteId("nowhere");
  EXPECT_CODE(sites_.Update(Soon(), site), absl::StatusCode::kNotFound);
}

TEST_F(SiteStoreTest, AnEtagOfADeletedSiteDoesNotFitItsSuccessor) {
  ASSERT_OK_AND_ASSIGN(storage::Site old, sites_.Create(Soon(), MakeSite(SiteId("s"), "x"), ""));
  ASSERT_OK(sites_.Delete(Soon(), old.id, old.etag, false));
  DeleteSite(old.id);
  ASSERT_OK(sites_.Create(Soon(), MakeSite(SiteId("s"), "x"), ""));
  EXPECT_CODE(sites_.Update(Soon(), old), absl::StatusCode::kAborted);
  EXPECT_CODE(sites_.Delete(Soon(), old.id, old.etag, true), absl::StatusCode::kAborted);
}

TEST_F(SiteStoreTest, DeletesAllThatBelongsToTheSiteAndNothingElse) {
  const TestBlob blob("image");
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, {ScanRecord(1), ImageRecord(2, blob.ref())}, {blob.view()}));
  const SessionId deleted = NewSession("s2");
  ASSERT_OK(Append(deleted, ScanRecords(1, 2)));
  ASSERT_OK(sessions_.Delete(Soon(), site_, deleted));
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kImport;
  revision.content_sha256 = blob.sha256();
  revision.tiles = {{{0, 0}, blob.sha256()}};
  ASSERT_OK(revisions_.Add(Soon(), site_, map_, revision, {}));
  ASSERT_OK(sites_.Create(Soon(), MakeSite(SiteId("other"), "Other"), ""));
  ASSERT_OK(blobs_.Put(Soon(), SiteId("other"), {blob.view()}));

  EXPECT_STATUS(sites_.Delete(Soon(), site_, 0, false), absl::StatusCode::kFailedPrecondition,
                HasSubstr("1 maps, 1 robots and 1 sessions"));
  EXPECT_OK(sites_.Get(Soon(), site_));
  DeleteSite(site_);
  EXPECT_CODE(sites_.Get(Soon(), site_), absl::StatusCode::kNotFound);
  EXPECT_CODE(sites_.Delete(Soon(), site_, 0, true), absl::StatusCode::kNotFound);
  // Every table that has a site's rows, found in the catalogue so that a new table is not forgotten.
  for (const std::string& table : database_.Sql("SELECT table_name FROM information_schema.columns"
                                                " WHERE table_schema = 'enfilade' AND column_name = 'site_id'"
                                                // It outlives its site.
                                                " AND table_name <> 'audit_log'")) {
    EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade." + table + " WHERE site_id = 'campus'"), "0") << table;
  }
  EXPECT_OK(blobs_.Get(Soon(), SiteId("other"), blob.sha256()));
}

}  // namespace
}  // namespace enfilade::testing

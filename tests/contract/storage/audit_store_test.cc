// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/audit_store.h"

#include <algorithm>

#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// "created sites of", "deleted robots/r1 of ada", the oldest first.
class AuditStoreTest : public StoreTest {
 protected:
  static storage::CallContext As(const std::string& actor) {
    storage::CallContext context = Soon();
    context.actor = actor;
    return context;
  }
  std::vector<storage::AuditEntry> Entries(const std::string& resource = "") {
    const auto entries = audit_.List(Soon(), site_, resource, 0, 1000);
    EXPECT_OK(entries);
    return *entries;
  }
  storage::AuditEntry Newest(const std::string& resource) {
    const std::vector<storage::AuditEntry> entries = Entries(resource);
    return entries.empty() ? storage::AuditEntry() : entries.front();
  }
  std::vector<std::string> Changes(const std::string& resource = "") {
    static constexpr std::array<const char*, 4> kActions = {"", "created", "updated", "deleted"};
    std::vector<std::string> changes;
    for (const storage::AuditEntry& entry : Entries(resource)) {
      changes.push_back(std::string(kActions.at(static_cast<std::size_t>(entry.action))) + " " + entry.resource +
                        " by " + entry.actor);
      EXPECT_EQ(entry.before.empty(), entry.action == storage::AuditAction::kCreated);
      EXPECT_EQ(entry.after.empty(), entry.action == storage::AuditAction::kDeleted);
    }
    std::reverse(changes.begin(), changes.end());
    return changes;
  }
};

TEST_F(AuditStoreTest, KnowsWhoCreatedChangedAndDeletedARobot) {
  ASSERT_OK_AND_ASSIGN(storage::Robot robot, robots_.Create(As("ada"), MakeRobot(site_, RobotId("r2"), "Two"), ""));
  robot.display_name = "Second";
  ASSERT_OK(robots_.Update(As("bob"), robot));
  ASSERT_OK(robots_.Delete(As("eve"), site_, robot.id, 0));
  EXPECT_THAT(Changes("robots/r2"),
              ElementsAre("created robots/r2 by ada", "updated robots/r2 by bob", "deleted robots/r2 by eve"));
  EXPECT_THAT(Newest("robots/r2").before, HasSubstr("Second"));
}

TEST_F(AuditStoreTest, KnowsWhoMadeFinishedAndDeletedASession) {
  ASSERT_OK(sessions_.Create(As("ada"), MakeSession(site_, SessionId("s1"), robot_, std::nullopt), ""));
  ASSERT_OK(Append(SessionId("s1"), ScanRecords(1, 5)));
  ASSERT_OK(sessions_.Finish(As("bob"), site_, SessionId("s1"), 5));
  ASSERT_OK(sessions_.Delete(As("eve"), site_, SessionId("s1")));
  EXPECT_THAT(Changes("sessions/s1"),
              ElementsAre("created sessions/s1 by ada", "updated sessions/s1 by bob", "deleted sessions/s1 by eve"));
  // What was lost.
  EXPECT_THAT(Newest("sessions/s1").before, AllOf(HasSubstr("\"laser_scans\": 5"), HasSubstr("r1")));
}

TEST_F(AuditStoreTest, KnowsWhoImportedARevision) {
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kImport;
  revision.raster_header = std::string(100, 'h');
  const TestBlob tile("tile");
  revision.content_sha256 = tile.sha256();
  revision.tiles = {{{0, 0}, tile.sha256()}};
  ASSERT_OK(revisions_.Add(As("ada"), site_, map_, revision, {tile.view()}));
  EXPECT_THAT(Changes("maps/hall/revisions"), ElementsAre("created maps/hall/revisions/1 by ada"));
  EXPECT_THAT(Newest("maps/hall/revisions").after, AllOf(HasSubstr("content_sha256"), Not(HasSubstr("raster_header"))));
}

TEST_F(AuditStoreTest, KnowsWhoChangedAndDeletedASiteWhenItIsGone) {
  ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
  site.raw_retention = std::chrono::seconds(60);
  ASSERT_OK(sites_.Update(As("ada"), site));
  NewSession("s1");
  const SiteId gone = site_;
  ASSERT_OK(sites_.Delete(As("eve"), gone, 0, true));
  while (true) {
    ASSERT_OK_AND_ASSIGN(const auto sites, storage::SiteDeletion(*pool_).List(Soon()));
    if (sites.empty()) break;
    EXPECT_EQ(sites[0].actor, "eve");
    ASSERT_OK(storage::SiteDeletion(*pool_).DeletePortion(As(sites[0].actor), gone, 1000));
  }
  const std::vector<std::string> changes = Changes();
  EXPECT_EQ(changes.front(), "created  by ");
  EXPECT_THAT(changes, Contains("updated  by ada"));
  EXPECT_THAT(changes, Contains("deleted  by eve"));
  EXPECT_THAT(changes, Contains("deleted robots/r1 by eve"));
  EXPECT_THAT(changes, Contains("deleted sessions/s1 by eve"));
  EXPECT_THAT(changes, Contains("deleted maps/hall by eve"));
}

TEST_F(AuditStoreTest, RecordingWritesNoEntries) {
  const SessionId session = NewSession("s1");
  const std::size_t before = Entries().size();
  ASSERT_OK(Append(session, ScanRecords(1, 50)));
  EXPECT_EQ(Entries().size(), before);
  EXPECT_THAT(Changes("sessions/s2"), IsEmpty());
}

}  // namespace
}  // namespace enfilade::testing

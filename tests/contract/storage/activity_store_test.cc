// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/activity_store.h"

#include <gmock/gmock.h>

#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using storage::SessionState;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class ActivityStoreTest : public StoreTest {
 protected:
  storage::SiteActivity Read(const storage::ActivityQuery& query = {}) {
    const auto activity = activity_.Read(Soon(), site_, query);
    EXPECT_OK(activity);
    return activity.value_or(storage::SiteActivity());
  }
  static std::vector<std::string> NamesOf(const std::vector<storage::SessionProgress>& sessions) {
    std::vector<std::string> names;
    for (const storage::SessionProgress& session : sessions) names.push_back(session.id.value());
    return names;
  }

  storage::ActivityStore activity_{*pool_};
};

TEST_F(ActivityStoreTest, ReadsSessionsThatAreNotOverAndTheOnesThatWereAskedFor) {
  const SessionId open = NewSession("open");
  const SessionId ended = NewSession("ended", /*mapped=*/false);
  const SessionId gone = NewSession("gone");
  ASSERT_OK(sessions_.Finish(Soon(), site_, ended, 0));
  ASSERT_OK(sessions_.Delete(Soon(), site_, gone));
  EXPECT_THAT(NamesOf(Read().sessions), ElementsAre("open"));
  const auto sessions = Read({.also = {ended, gone}}).sessions;
  ASSERT_THAT(NamesOf(sessions), ElementsAre("ended", "gone", "open"));
  EXPECT_EQ(sessions[0].state, SessionState::kMapped);
  EXPECT_TRUE(sessions[0].is_over() && sessions[1].deleted && !sessions[2].is_over());
  EXPECT_EQ(sessions[2].map, map_);
  EXPECT_EQ(sessions[2].robot, robot_);
}

TEST_F(ActivityStoreTest, TellsWhatHasEndedAndGoneSince) {
  const TimeNs before = Read().time;
  const SessionId ended = NewSession("ended", /*mapped=*/false);
  ASSERT_OK(sessions_.Finish(Soon(), site_, ended, 0));
  ASSERT_OK(sessions_.Delete(Soon(), site_, NewSession("gone")));
  ASSERT_OK(robots_.Create(Soon(), MakeRobot(site_, RobotId("r2"), "Two"), ""));
  ASSERT_OK(robots_.Delete(Soon(), site_, RobotId("r2"), 0));
  const storage::SiteActivity activity = Read({.also = {}, .since = before});
  EXPECT_THAT(NamesOf(activity.sessions), ElementsAre("ended"));
  EXPECT_THAT(activity.removed_sessions, ElementsAre(SessionId("gone")));
  ASSERT_OK_AND_ASSIGN(const storage::PastActivity past, activity_.ReadPast(Soon(), site_, before, before, 10));
  EXPECT_THAT(NamesOf(past.ended), ElementsAre("ended"));
  EXPECT_THAT(past.removed_sessions, ElementsAre(SessionId("gone")));
  EXPECT_THAT(past.removed_robots, ElementsAre(RobotId("r2")));
  const TimeNs after = Read().time + kNsPerSecond;
  ASSERT_OK_AND_ASSIGN(const storage::PastActivity none, activity_.ReadPast(Soon(), site_, after, after, 10));
  EXPECT_THAT(none.ended, IsEmpty());
  EXPECT_THAT(none.removed_robots, IsEmpty());
}

TEST_F(ActivityStoreTest, ReadsCurrentRevisionsAndTheBacklogOfTheSiteOnly) {
  EXPECT_THAT(Read().revisions, IsEmpty());
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kImport;
  revision.geometry = {0.05, {}, 1, 1};
  revision.raster_header = "h";
  for (const char content : {'a', 'b'}) {
    revision.content_sha256 = std::string(32, content);
    ASSERT_OK(revisions_.Add(Soon(), site_, map_, revision, {}));
  }
  const auto revisions = Read().revisions;
  ASSERT_EQ(revisions.size(), 1U);
  EXPECT_EQ(revisions[0].map, map_);
  EXPECT_EQ(revisions[0].number, 2);
  EXPECT_EQ(Read().waiting_sessions, 0);
  const SessionId finished = NewSession("finished");
  ASSERT_OK(sessions_.Finish(Soon(), site_, finished, 0));
  EXPECT_EQ(Read().waiting_sessions, 1);
  EXPECT_THAT(NamesOf(Read().sessions), ElementsAre("finished"));
  EXPECT_CODE(activity_.Read(Soon(), SiteId("nowhere"), {}), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing

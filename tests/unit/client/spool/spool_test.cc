// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/spool/spool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "core/base/uuid.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/spool/spool_samples.h"

namespace enfilade::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::ImageItem;
using testing::NumberedScan;
using testing::SampleSession;
using testing::TemporaryDirectory;

constexpr std::int64_t kMany = 1'000'000;
const SessionId kSession("run-1");

class SpoolTest : public ::testing::Test {
 protected:
  void SetUp() override { Open(); }

  void Open(const SpoolOptions& options = {}) {
    spool_.reset();
    auto spool = Spool::Open(path(), options);
    ASSERT_OK(spool);
    spool_ = *std::move(spool);
  }
  void OpenWithSession(const SpoolOptions& options = {}) {
    Open(options);
    ASSERT_OK(spool_->CreateSession(SampleSession()));
  }
  void AppendScans(int first, int last) {
    std::vector<SpoolItem> items;
    for (int i = first; i <= last; ++i) items.push_back({NumberedScan(i), {}});
    ASSERT_OK(spool_->Append(kSession, items));
  }
  std::vector<std::int64_t> Sequences(std::int64_t after = 0, std::int64_t max_records = kMany,
                                      std::int64_t max_bytes = kMany) {
    std::vector<std::int64_t> sequences;
    const auto batch = spool_->ReadBatch(kSession, after, max_records, max_bytes);
    EXPECT_OK(batch);
    for (const sensor::Record& record : *batch) sequences.push_back(record.sequence);
    return sequences;
  }
  std::string path() const { return (directory_.path() / "robot.spool").string(); }

  TemporaryDirectory directory_;
  std::unique_ptr<Spool> spool_;
};

TEST_F(SpoolTest, GivesBackWhatWasAppendedInOrder) {
  OpenWithSession();
  EXPECT_EQ(*spool_->Append(kSession, NumberedScan(1)), 1);
  EXPECT_EQ(*spool_->Append(kSession, sensor::Odometry{5, {1.0, 2.0, 0.5}}), 2);
  ASSERT_OK_AND_ASSIGN(const auto batch, spool_->ReadBatch(kSession, 0, kMany, kMany));
  ASSERT_EQ(batch.size(), 2U);
  EXPECT_EQ(batch[0], (sensor::Record{1, NumberedScan(1)}));
  EXPECT_EQ(batch[1], (sensor::Record{2, sensor::Odometry{5, {1.0, 2.0, 0.5}}}));
}

TEST_F(SpoolTest, LimitsBatchesByCountAndBytes) {
  OpenWithSession();
  AppendScans(1, 10);
  EXPECT_THAT(Sequences(0, 3), ElementsAre(1, 2, 3));
  EXPECT_THAT(Sequences(8), ElementsAre(9, 10));
  EXPECT_THAT(Sequences(0, kMany, 1), ElementsAre(1)) << "at least one";
  EXPECT_THAT(Sequences(0, kMany, 2000), ElementsAre(1, 2)) << "a scan of 180 beams has some 800 bytes";
  EXPECT_TRUE(Sequences(10).empty());
}

TEST_F(SpoolTest, GoesOnWhereItWasAfterReopening) {
  OpenWithSession();
  AppendScans(1, 5);
  ASSERT_OK(spool_->Acknowledge(kSession, 2));
  Open();
  const auto session = spool_->FindSession(kSession);
  ASSERT_TRUE(session.has_value());
  EXPECT_EQ(session->site, SiteId("campus"));
  EXPECT_EQ(session->robot, RobotId("r1"));
  EXPECT_EQ(session->map, "hall");
  EXPECT_EQ(session->request_id, SampleSession().request_id);
  EXPECT_EQ(session->source, "test");
  EXPECT_EQ(session->last_sequence, 5);
  EXPECT_EQ(session->acknowledged_sequence, 2);
  EXPECT_EQ(session->pending(), 3);
  EXPECT_THAT(Sequences(2), ElementsAre(3, 4, 5));
  EXPECT_EQ(*spool_->Append(kSession, NumberedScan(6)), 6);
}

TEST_F(SpoolTest, RemembersAnEntryThatIsFoundLater) {
  OpenWithSession();
  AppendScans(1, 5);
  const sensor::SessionEntry entry{std::nullopt, PoseWithCovariance{{1.0, 2.0, 3.0}, Eigen::Matrix3d::Identity()},
                                   Pose2{4.0, 5.0, 1.0}};
  ASSERT_OK(spool_->SetEntry(kSession, "cellar", entry));
  EXPECT_EQ(spool_->FindSession(kSession)->map, "cellar");
  Open();
  const auto session = spool_->FindSession(kSession);
  EXPECT_EQ(session->map, "cellar");
  EXPECT_EQ(session->entry.T_map_robot->pose, (Pose2{1.0, 2.0, 3.0}));
  EXPECT_EQ(session->entry.T_odom_robot, (Pose2{4.0, 5.0, 1.0}));
  EXPECT_THAT(Sequences(0), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_TRUE(absl::IsNotFound(spool_->SetEntry(SessionId("none"), "cellar", entry)));
}

TEST_F(SpoolTest, SequencesNeverRestartAlsoWhereEverythingIsTrimmed) {
  OpenWithSession();
  AppendScans(1, 3);
  ASSERT_OK(spool_->Acknowledge(kSession, 3));
  Open();
  EXPECT_EQ(*spool_->Append(kSession, NumberedScan(4)), 4);
}

TEST_F(SpoolTest, TrimsWhatIsAcknowledged) {
  OpenWithSession();
  AppendScans(1, 5000);
  const std::int64_t full = spool_->usage().bytes;
  ASSERT_OK(spool_->Acknowledge(kSession, 4990));
  EXPECT_EQ(spool_->usage().records, 10);
  EXPECT_EQ(spool_->usage().bytes, full / 500);
  ASSERT_OK(spool_->Acknowledge(kSession, 17)) << "late and of no effect";
  EXPECT_EQ(spool_->FindSession(kSession)->acknowledged_sequence, 4990);
  EXPECT_THAT(Sequences(4998), ElementsAre(4999, 5000));
  const std::int64_t bytes = spool_->usage().bytes;
  Open();
  EXPECT_EQ(spool_->usage().bytes, bytes) << "the count must not drift from the file's";
  ASSERT_OK(spool_->Acknowledge(kSession, 5000));
  EXPECT_EQ(spool_->usage().bytes, 0);
}

TEST_F(SpoolTest, AcknowledgementsBeyondTheLastRecordMeanTheLast) {
  OpenWithSession();
  AppendScans(1, 3);
  ASSERT_OK(spool_->Acknowledge(kSession, 99));
  EXPECT_EQ(spool_->FindSession(kSession)->acknowledged_sequence, 3);
  EXPECT_EQ(*spool_->Append(kSession, NumberedScan(4)), 4);
}

TEST_F(SpoolTest, RefusesTheNewWhenFullAndKeepsTheOld) {
  SpoolOptions options;
  options.max_bytes = 10'000;
  OpenWithSession(options);
  absl::StatusOr<std::int64_t> last = 0;
  int appended = 0;
  while ((last = spool_->Append(kSession, NumberedScan(appended + 1))).ok()) ++appended;
  EXPECT_STATUS(last, absl::StatusCode::kResourceExhausted, HasSubstr("of 10000 bytes are used"));
  EXPECT_GT(appended, 5);
  EXPECT_EQ(Sequences().size(), static_cast<std::size_t>(appended));
  EXPECT_EQ(spool_->usage().refused, 1);
  EXPECT_LE(spool_->usage().bytes, 10'000);

  ASSERT_OK(spool_->Acknowledge(kSession, 1));
  EXPECT_EQ(*spool_->Append(kSession, NumberedScan(99)), appended + 1) << "a refused record takes no sequence";
}

TEST_F(SpoolTest, TakesAllItemsOrNone) {
  SpoolOptions options;
  options.max_bytes = 3000;
  OpenWithSession(options);
  std::vector<SpoolItem> items(5, SpoolItem{NumberedScan(1), {}});
  EXPECT_CODE(spool_->Append(kSession, items), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(Sequences().empty());
  sensor::LaserScan empty = NumberedScan(1);
  empty.ranges.clear();
  items = {{NumberedScan(1), {}}, {empty, {}}};
  EXPECT_STATUS(spool_->Append(kSession, items), absl::StatusCode::kInvalidArgument, HasSubstr("item 1: "));
  EXPECT_TRUE(Sequences().empty());
}

TEST_F(SpoolTest, StoresABlobOnceAndDropsItWithItsLastRecord) {
  OpenWithSession();
  const std::string content(100'000, 'x');
  for (int i = 0; i < 3; ++i) ASSERT_OK(spool_->Append(kSession, std::vector<SpoolItem>{ImageItem(content)}));
  EXPECT_LT(spool_->usage().bytes, 102'000);
  const sensor::BlobRef blob = std::get<sensor::Image>(ImageItem(content).payload).content;
  ASSERT_OK(spool_->Acknowledge(kSession, 2));
  EXPECT_EQ(*spool_->ReadBlob(blob), content);
  ASSERT_OK(spool_->Acknowledge(kSession, 3));
  EXPECT_CODE(spool_->ReadBlob(blob), absl::StatusCode::kNotFound);
  EXPECT_EQ(spool_->usage().bytes, 0);
}

TEST_F(SpoolTest, RefusesContentThatDoesNotFitItsReference) {
  OpenWithSession();
  SpoolItem item = ImageItem("abc");
  item.content = "abd";
  EXPECT_STATUS(spool_->Append(kSession, std::vector<SpoolItem>{item}), absl::StatusCode::kInvalidArgument,
                HasSubstr("sha256"));
  item.content = "ab";
  EXPECT_STATUS(spool_->Append(kSession, std::vector<SpoolItem>{item}), absl::StatusCode::kInvalidArgument,
                HasSubstr("size_bytes is 3"));
  EXPECT_CODE(spool_->Append(kSession, std::vector<SpoolItem>{{NumberedScan(1), "abc"}}),
              absl::StatusCode::kInvalidArgument);
}

TEST_F(SpoolTest, QuarantineLeavesAWithheldRecordAndKeepsTheOriginal) {
  OpenWithSession();
  AppendScans(1, 2);
  ASSERT_OK(spool_->Append(kSession, std::vector<SpoolItem>{ImageItem("abc")}));
  ASSERT_OK(spool_->Quarantine(kSession, 3, "the server says \"no\""));
  ASSERT_OK_AND_ASSIGN(const auto batch, spool_->ReadBatch(kSession, 2, kMany, kMany));
  ASSERT_EQ(batch.size(), 1U);
  EXPECT_EQ(batch[0], (sensor::Record{3, sensor::Withheld{"the server says \"no\""}}));
  EXPECT_CODE(spool_->Quarantine(kSession, 3, "again"), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(spool_->Quarantine(kSession, 4, "none"), absl::StatusCode::kNotFound);

  ASSERT_OK(spool_->Acknowledge(kSession, 3));
  Open();
  EXPECT_EQ(spool_->usage().quarantined, 1);
  ASSERT_OK_AND_ASSIGN(const auto kept, spool_->ListQuarantined(kSession));
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0].record, (sensor::Record{3, ImageItem("abc").payload}));
  EXPECT_EQ(kept[0].reason, "the server says \"no\"");
  EXPECT_EQ(*spool_->ReadBlob(std::get<sensor::Image>(kept[0].record.payload).content), "abc");
}

TEST_F(SpoolTest, ReasonsAreCutToWhatTheServerTakes) {
  OpenWithSession();
  AppendScans(1, 1);
  ASSERT_OK(spool_->Quarantine(kSession, 1, std::string(100'000, 'r')));
  ASSERT_OK_AND_ASSIGN(const auto batch, spool_->ReadBatch(kSession, 0, kMany, kMany));
  EXPECT_OK(sensor::Validate(batch.at(0)));
}

TEST_F(SpoolTest, RemovingASessionLeavesTheOthers) {
  OpenWithSession();
  ASSERT_OK(spool_->CreateSession(SampleSession("run-2")));
  AppendScans(1, 5);
  ASSERT_OK(spool_->Append(SessionId("run-2"), NumberedScan(1)));
  ASSERT_OK(spool_->RemoveSession(kSession));
  EXPECT_FALSE(spool_->FindSession(kSession).has_value());
  EXPECT_EQ(spool_->ListSessions().size(), 1U);
  EXPECT_EQ(spool_->usage().records, 1);
  EXPECT_CODE(spool_->RemoveSession(kSession), absl::StatusCode::kNotFound);
  ASSERT_OK(spool_->CreateSession(SampleSession()));
  EXPECT_TRUE(Sequences().empty());
}

TEST_F(SpoolTest, AFinishedSessionTakesNoMore) {
  OpenWithSession();
  AppendScans(1, 1);
  ASSERT_OK(spool_->MarkFinished(kSession));
  EXPECT_STATUS(spool_->Append(kSession, NumberedScan(2)), absl::StatusCode::kFailedPrecondition,
                HasSubstr("run-1 is finished"));
  ASSERT_OK(spool_->MarkClosed(kSession));
  Open();
  EXPECT_TRUE(spool_->FindSession(kSession)->finished);
  EXPECT_TRUE(spool_->FindSession(kSession)->closed);
}

TEST_F(SpoolTest, UnknownSessionsAreNamed) {
  EXPECT_STATUS(spool_->Append(kSession, NumberedScan(1)), absl::StatusCode::kNotFound, HasSubstr("run-1"));
  EXPECT_CODE(spool_->ReadBatch(kSession, 0, 1, 1), absl::StatusCode::kNotFound);
  EXPECT_CODE(spool_->Acknowledge(kSession, 1), absl::StatusCode::kNotFound);
  ASSERT_OK(spool_->CreateSession(SampleSession("it's; DROP TABLE \"sessions\"")));
  EXPECT_TRUE(spool_->FindSession(SessionId("it's; DROP TABLE \"sessions\"")).has_value());
  EXPECT_CODE(spool_->CreateSession(SampleSession("it's; DROP TABLE \"sessions\"")), absl::StatusCode::kAlreadyExists);
}

TEST_F(SpoolTest, ThreadsAppendSideBySideWithoutHoles) {
  OpenWithSession();
  constexpr int kThreads = 8;
  constexpr int kEach = 100;
  std::vector<std::vector<std::int64_t>> sequences(kThreads);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < kEach; ++i) sequences[t].push_back(*spool_->Append(kSession, NumberedScan(t * 1000 + i)));
    });
  }
  std::thread acknowledging([&] {
    for (int i = 0; i < 200; ++i)
      EXPECT_OK(spool_->Acknowledge(kSession, spool_->FindSession(kSession)->last_sequence / 2));
  });
  for (std::thread& thread : threads) thread.join();
  acknowledging.join();
  std::vector<std::int64_t> all;
  for (const auto& of_thread : sequences) {
    EXPECT_TRUE(std::is_sorted(of_thread.begin(), of_thread.end()));
    all.insert(all.end(), of_thread.begin(), of_thread.end());
  }
  std::sort(all.begin(), all.end());
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], static_cast<std::int64_t>(i) + 1);
  EXPECT_EQ(all.size(), static_cast<std::size_t>(kThreads * kEach));
  const std::int64_t acknowledged = spool_->FindSession(kSession)->acknowledged_sequence;
  EXPECT_EQ(spool_->usage().records, kThreads * kEach - acknowledged);
}

TEST_F(SpoolTest, WaitersWakeOnRecordsOnTheFinishAndOnSpace) {
  SpoolOptions options;
  options.max_bytes = 1000;
  OpenWithSession(options);
  const auto far = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  std::thread waiter([&] { spool_->WaitForRecords(kSession, 0, far); });
  AppendScans(1, 1);
  waiter.join();
  waiter = std::thread([&] { spool_->WaitForSpace(900, far); });
  ASSERT_OK(spool_->Acknowledge(kSession, 1));
  waiter.join();
  waiter = std::thread([&] { spool_->WaitForRecords(kSession, 1, far); });
  ASSERT_OK(spool_->MarkFinished(kSession));
  waiter.join();
}

TEST_F(SpoolTest, OneProcessAtATime) {
  EXPECT_STATUS(Spool::Open(path()), absl::StatusCode::kFailedPrecondition,
                HasSubstr("in use by process " + std::to_string(getpid())));
  spool_.reset();
  EXPECT_OK(Spool::Open(path()));
}

TEST(Uuid, IsRandomAndAValidResourceId) {
  const std::string id = NewUuid();
  EXPECT_NE(id, NewUuid());
  EXPECT_EQ(id.size(), 36U);
  EXPECT_EQ(id[14], '4');
  EXPECT_NE(std::string("89ab").find(id[19]), std::string::npos);
  EXPECT_TRUE(IsValidResourceId(id));
}

}  // namespace
}  // namespace enfilade::client

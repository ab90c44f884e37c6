// SPDX-License-Identifier: Apache-2.0
// What may befall the file: another program's, damage, a killed process, a full disk.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "client/sdk/spool/spool.h"
#include "client/sdk/spool/sqlite.h"
#include "core/base/environment.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/spool/spool_samples.h"

namespace enfilade::client {
namespace {

using ::testing::HasSubstr;
using testing::NumberedScan;
using testing::SampleSession;
using testing::TemporaryDirectory;

const SessionId kRun("run-1");

class SpoolFile : public ::testing::Test {
 protected:
  std::string path() const { return (directory_.path() / "robot.spool").string(); }

  void Fill(int scans) const {
    auto spool = Spool::Open(path());
    ASSERT_OK(spool);
    ASSERT_OK((*spool)->CreateSession(SampleSession()));
    for (int i = 1; i <= scans; ++i) ASSERT_OK((*spool)->Append(kRun, NumberedScan(i)));
  }
  void Execute(const std::string& sql) const {
    auto database = SqliteDatabase::Open(path());
    ASSERT_OK(database);
    ASSERT_OK(database->Execute(sql));
  }

  TemporaryDirectory directory_;
};

TEST_F(SpoolFile, RefusesOtherFiles) {
  std::ofstream(path()) << "this is a letter to my aunt, and not a short one either: it goes on and on and on";
  EXPECT_STATUS(Spool::Open(path()), absl::StatusCode::kDataLoss, HasSubstr("robot.spool: "));
  std::filesystem::remove(path());
  Execute("CREATE TABLE recipes (name TEXT)");
  EXPECT_STATUS(Spool::Open(path()), absl::StatusCode::kFailedPrecondition, HasSubstr("another program's file"));
  EXPECT_CODE(Spool::Open((directory_.path() / "none" / "a.spool").string()), absl::StatusCode::kNotFound);
}

TEST_F(SpoolFile, RefusesANewerLayout) {
  Fill(1);
  Execute("PRAGMA user_version = 99");
  EXPECT_STATUS(Spool::Open(path()), absl::StatusCode::kFailedPrecondition, HasSubstr("layout 99"));
}

TEST_F(SpoolFile, BringsTheFirstLayoutUpToThisOne) {
  Fill(3);
  Execute("ALTER TABLE sessions DROP COLUMN entry; ALTER TABLE sessions DROP COLUMN surroundings");
  Execute("PRAGMA user_version = 1");
  ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
  const auto session = spool->FindSession(kRun);
  ASSERT_TRUE(session.has_value());
  EXPECT_EQ(session->last_sequence, 3);
  EXPECT_EQ(session->entry.previous, std::nullopt);
  EXPECT_EQ(session->environment, std::nullopt);
}

TEST_F(SpoolFile, BringsTheSecondLayoutUpToThisOne) {
  Fill(3);
  Execute("ALTER TABLE sessions DROP COLUMN surroundings; PRAGMA user_version = 2");
  ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
  ASSERT_TRUE(spool->FindSession(kRun).has_value());
  EXPECT_EQ(spool->FindSession(kRun)->environment, std::nullopt);
}

TEST_F(SpoolFile, KeepsHowASessionCameIntoItsMap) {
  SpoolSession after_a_door = SampleSession("run-2");
  after_a_door.entry.previous = kRun;
  SpoolSession on_an_old_map = SampleSession("run-3");
  on_an_old_map.entry.T_map_robot = PoseWithCovariance{{1.0, 2.0, 0.5}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal()};
  on_an_old_map.entry.T_odom_robot = Pose2{-1.0, 0.0, 3.0};
  SpoolSession in_a_yard = SampleSession("run-4");
  in_a_yard.environment = Environment::kOutdoor;
  {
    ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
    ASSERT_OK(spool->CreateSession(after_a_door));
    ASSERT_OK(spool->CreateSession(on_an_old_map));
    ASSERT_OK(spool->CreateSession(in_a_yard));
  }
  ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
  EXPECT_EQ(spool->FindSession(after_a_door.id)->entry.previous, kRun);
  const sensor::SessionEntry entry = spool->FindSession(on_an_old_map.id)->entry;
  ASSERT_TRUE(entry.T_map_robot.has_value());
  EXPECT_EQ(entry.T_map_robot->pose, on_an_old_map.entry.T_map_robot->pose);
  EXPECT_EQ(entry.T_map_robot->covariance, on_an_old_map.entry.T_map_robot->covariance);
  EXPECT_EQ(entry.T_odom_robot, on_an_old_map.entry.T_odom_robot);
  EXPECT_EQ(spool->FindSession(in_a_yard.id)->environment, Environment::kOutdoor);
  EXPECT_EQ(spool->FindSession(on_an_old_map.id)->environment, std::nullopt);
}

TEST_F(SpoolFile, ReportsDamage) {
  Fill(200);
  const auto size = std::filesystem::file_size(path());
  ASSERT_GT(size, 100'000U);
  std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 2));
  file << std::string(20'000, '\xEE');
  file.close();
  EXPECT_STATUS(Spool::Open(path()), absl::StatusCode::kDataLoss, HasSubstr("robot.spool: "));
}

TEST_F(SpoolFile, SendsADamagedRecordAsWithheldAndTheOthersAsTheyAre) {
  Fill(3);
  Execute("UPDATE records SET payload = zeroblob(length(payload)) WHERE sequence = 2");
  ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
  ASSERT_OK_AND_ASSIGN(const auto batch, spool->ReadBatch(kRun, 0, 10, 100'000));
  ASSERT_EQ(batch.size(), 3U);
  EXPECT_EQ(batch[0], (sensor::Record{1, NumberedScan(1)}));
  EXPECT_THAT(std::get<sensor::Withheld>(batch[1].payload).reason, HasSubstr("damaged on the robot's disk"));
  EXPECT_EQ(batch[2], (sensor::Record{3, NumberedScan(3)}));
}

// A process that appends, reports each sequence that is durable, trims now and then, and never ends by itself.
[[noreturn]] void AppendForEver(const std::string& path, int report) {
  auto spool = Spool::Open(path);
  if (!spool.ok()) _exit(3);
  std::int64_t last = (*spool)->FindSession(kRun)->last_sequence;
  while (true) {
    std::vector<SpoolItem> items;
    for (std::int64_t i = 0; i < 1 + last % 7; ++i) items.push_back({NumberedScan(static_cast<int>(last + i + 1)), {}});
    const auto appended = (*spool)->Append(kRun, items);
    if (!appended.ok()) _exit(4);
    last = *appended;
    if (write(report, &last, sizeof(last)) != sizeof(last)) _exit(5);
    if (last % 5 == 0 && !(*spool)->Acknowledge(kRun, last / 2).ok()) _exit(6);
  }
}

TEST_F(SpoolFile, LosesNothingDurableWhenTheProcessIsKilled) {
  {
    ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
    ASSERT_OK(spool->CreateSession(SampleSession()));
  }
  std::mt19937 random(11);
  std::int64_t reported = 0;
  for (int round = 0; round < 15; ++round) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) AppendForEver(path(), ends[1]);
    close(ends[1]);
    // Killed after a random number of reports, and a little later, in the middle of something.
    for (std::uint32_t i = 0; i < 1 + random() % 40; ++i) {
      ASSERT_EQ(read(ends[0], &reported, sizeof(reported)), static_cast<ssize_t>(sizeof(reported)));
    }
    usleep(static_cast<useconds_t>(random() % 3000));
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child ended by itself, with " << WEXITSTATUS(status);
    while (read(ends[0], &reported, sizeof(reported)) == static_cast<ssize_t>(sizeof(reported))) {
    }
    close(ends[0]);

    ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
    const SpoolSession session = *spool->FindSession(kRun);
    ASSERT_GE(session.last_sequence, reported) << "a durable record is gone";
    ASSERT_OK_AND_ASSIGN(const auto rest, spool->ReadBatch(kRun, session.acknowledged_sequence, 1 << 30, 1LL << 40));
    ASSERT_EQ(static_cast<std::int64_t>(rest.size()), session.pending());
    ASSERT_EQ(spool->usage().records, session.pending());
    for (const sensor::Record& record : rest) {
      ASSERT_EQ(record, (sensor::Record{record.sequence, NumberedScan(static_cast<int>(record.sequence))}));
    }
  }
}

// In a process of its own, as the limit holds for a process: files grow no further than 1 MB.
[[noreturn]] void AppendUntilTheDiskIsFull(const std::string& path) {
  signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{1'000'000, 1'000'000};
  setrlimit(RLIMIT_FSIZE, &limit);
  auto spool = Spool::Open(path);
  if (!spool.ok() || !(*spool)->CreateSession(SampleSession()).ok()) _exit(3);
  int appended = 0;
  absl::StatusOr<std::int64_t> last = 0;
  while (appended < 10'000 && (last = (*spool)->Append(kRun, NumberedScan(appended + 1))).ok()) ++appended;
  if (last.ok()) _exit(4);
  _exit((*spool)->FindSession(kRun)->last_sequence == appended && appended > 10 ? 0 : 5);
}

TEST_F(SpoolFile, AFullDiskRefusesTheNewAndKeepsTheOld) {
  const pid_t child = fork();
  if (child == 0) AppendUntilTheDiskIsFull(path());
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 0);
  ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path()));
  const std::int64_t last = spool->FindSession(kRun)->last_sequence;
  ASSERT_OK_AND_ASSIGN(const auto records, spool->ReadBatch(kRun, 0, 1 << 30, 1LL << 40));
  EXPECT_EQ(static_cast<std::int64_t>(records.size()), last);
  EXPECT_EQ(*spool->Append(kRun, NumberedScan(1)), last + 1);
}

}  // namespace
}  // namespace enfilade::client

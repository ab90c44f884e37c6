// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "client/cli/replay/log_feeder.h"
#include "client/cli/replay/replay_report.h"
#include "client/cli/replay/replay_session.h"
#include "client/sources/formats/json_lines_writer.h"
#include "core/base/uuid.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"
#include "tests/unit/client/spool/spool_samples.h"

namespace enfilade::cli {
namespace {

using client::Spool;
using client::SpoolOptions;
using client::SpoolSession;
using sources::LogReader;
using ::testing::HasSubstr;
using testing::LogFiles;
using testing::NumberedScan;
using testing::SampleSession;
using ::testing::SizeIs;
using Clock = LogFeeder::Clock;

const SessionId kRun("run-1");

class ReplayTest : public ::testing::Test {
 protected:
  void Open(std::int64_t max_bytes = 1 << 30) {
    spool_.reset();
    SpoolOptions options;
    options.max_bytes = max_bytes;
    auto spool = Spool::Open((files_.path() / "replay.spool").string(), options);
    ASSERT_OK(spool);
    spool_ = *std::move(spool);
  }
  // Scans a tenth of a second apart.
  std::filesystem::path WriteLog(int scans) const {
    std::string text = sources::JsonLinesHeader();
    for (int i = 1; i <= scans; ++i) text += *sources::ToJsonLine({Scan(i), {}});
    return files_.Write("drive.jsonl", text);
  }
  static sensor::LaserScan Scan(int number) {
    sensor::LaserScan scan = NumberedScan(number, 20);
    scan.time = number * kNsPerSecond / 10;
    return scan;
  }
  LogFeeder MakeFeeder(const std::filesystem::path& log, const LogFeeder::Options& options = {}) {
    return {*LogReader::Open(log), *spool_, kRun, options};
  }
  std::vector<sensor::Record> Spooled() {
    const SpoolSession session = *spool_->FindSession(kRun);
    return *spool_->ReadBatch(kRun, session.acknowledged_sequence, 1 << 20, 1 << 30);
  }

  LogFiles files_;
  std::unique_ptr<Spool> spool_;
};

TEST_F(ReplayTest, FeedsTheWholeLogInOrder) {
  Open();
  ASSERT_OK(spool_->CreateSession(SampleSession()));
  LogFeeder feeder = MakeFeeder(WriteLog(600));
  ASSERT_OK(feeder.SkipSpooled());
  int rounds = 0;
  while (*feeder.Feed(Clock::now())) ++rounds;
  EXPECT_EQ(rounds, 2) << "256 at a time";
  const std::vector<sensor::Record> records = Spooled();
  ASSERT_THAT(records, SizeIs(600));
  for (int i = 1; i <= 600; ++i) ASSERT_EQ(records[i - 1], (sensor::Record{i, Scan(i)}));
}

TEST_F(ReplayTest, GoesOnAfterWhatIsSpooled) {
  Open();
  ASSERT_OK(spool_->CreateSession(SampleSession()));
  const auto log = WriteLog(600);
  {
    LogFeeder broken_off = MakeFeeder(log);
    ASSERT_OK(broken_off.SkipSpooled());
    ASSERT_TRUE(*broken_off.Feed(Clock::now()));
  }
  ASSERT_OK(spool_->Acknowledge(kRun, 200));
  LogFeeder feeder = MakeFeeder(log);
  ASSERT_OK(feeder.SkipSpooled());
  while (*feeder.Feed(Clock::now())) {
  }
  const std::vector<sensor::Record> records = Spooled();
  ASSERT_THAT(records, SizeIs(400));
  for (int i = 201; i <= 600; ++i) ASSERT_EQ(records[i - 201], (sensor::Record{i, Scan(i)}));
}

TEST_F(ReplayTest, RefusesALogThatIsShorterThanWhatIsSpooled) {
  Open();
  ASSERT_OK(spool_->CreateSession(SampleSession()));
  for (int i = 0; i < 5; ++i) ASSERT_OK(spool_->Append(kRun, Scan(i)));
  LogFeeder feeder = MakeFeeder(WriteLog(3));
  EXPECT_STATUS(feeder.SkipSpooled(), absl::StatusCode::kFailedPrecondition,
                HasSubstr("has 5 records, but the log has only 3"));
}

TEST_F(ReplayTest, KeepsTheRecordedPace) {
  Open();
  ASSERT_OK(spool_->CreateSession(SampleSession()));
  LogFeeder::Options options;
  options.rate = 2.0;
  LogFeeder feeder = MakeFeeder(WriteLog(10), options);
  const Clock::time_point start{std::chrono::hours(5)};
  ASSERT_OK(feeder.SkipSpooled());
  ASSERT_TRUE(*feeder.Feed(start));
  EXPECT_THAT(Spooled(), SizeIs(1));
  EXPECT_EQ(feeder.next_due(start), start + std::chrono::milliseconds(50));
  ASSERT_TRUE(*feeder.Feed(start + std::chrono::milliseconds(49)));
  EXPECT_THAT(Spooled(), SizeIs(1));
  ASSERT_TRUE(*feeder.Feed(start + std::chrono::milliseconds(201)));
  EXPECT_THAT(Spooled(), SizeIs(5)) << "all that are due, after a pause";
  EXPECT_FALSE(*feeder.Feed(start + std::chrono::seconds(9)));
  EXPECT_THAT(Spooled(), SizeIs(10));
}

TEST_F(ReplayTest, WaitsWhileTheSpoolIsFullAndLosesNothing) {
  Open(3000);
  ASSERT_OK(spool_->CreateSession(SampleSession()));
  LogFeeder feeder = MakeFeeder(WriteLog(100));
  ASSERT_OK(feeder.SkipSpooled());
  std::int64_t expected = 1;
  while (*feeder.Feed(Clock::now())) {
    ASSERT_TRUE(feeder.spool_is_full());
    for (const sensor::Record& record : Spooled()) {
      ASSERT_EQ(record, (sensor::Record{expected, Scan(static_cast<int>(expected))}));
      ++expected;
    }
    ASSERT_OK(spool_->Acknowledge(kRun, expected - 1));
  }
  EXPECT_EQ(spool_->FindSession(kRun)->last_sequence, 100);
}

TEST_F(ReplayTest, EndsWhereNoRoomCanEverBe) {
  Open(100);
  ASSERT_OK(spool_->CreateSession(SampleSession()));
  LogFeeder feeder = MakeFeeder(WriteLog(3));
  EXPECT_STATUS(feeder.Feed(Clock::now()), absl::StatusCode::kResourceExhausted, HasSubstr("of 100 bytes"));
}

TEST_F(ReplayTest, ChecksTheLogToItsEnd) {
  const auto good = WriteLog(20);
  std::int64_t seen = 0;
  ASSERT_OK_AND_ASSIGN(const CheckedLog checked, CheckLog(good, {}, [&](std::int64_t entries) { seen = entries; }));
  EXPECT_EQ(checked.entries, 20);
  EXPECT_EQ(seen, 20);
  EXPECT_EQ(checked.counts.scans, 20);

  const auto bad = files_.Write("bad.jsonl", testing::Contents(good) + "{\"type\":\n");
  EXPECT_STATUS(CheckLog(bad, {}, [](std::int64_t) {}), absl::StatusCode::kInvalidArgument,
                HasSubstr("bad.jsonl:22: "));
  const auto nothing = files_.Write("nothing.jsonl", sources::JsonLinesHeader());
  EXPECT_STATUS(CheckLog(nothing, {}, [](std::int64_t) {}), absl::StatusCode::kInvalidArgument,
                HasSubstr("has no entries"));
}

TEST_F(ReplayTest, KnowsALogByItsContentAndOptions) {
  const auto source_of = [](const std::filesystem::path& log, const sources::LogOptions& options) {
    return CheckLog(log, options, [](std::int64_t) {})->source;
  };
  const auto log = WriteLog(20);
  const auto copy = files_.Write("copy.jsonl", testing::Contents(log));
  const std::string source = source_of(log, {});
  EXPECT_EQ(source_of(copy, {}), source);
  sources::LogOptions scans_only;
  scans_only.odometry = false;
  EXPECT_NE(source_of(log, scans_only), source);
  EXPECT_NE(source_of(WriteLog(21), {}), source);
}

TEST_F(ReplayTest, FindsTheSessionToGoOnWith) {
  Open();
  SpoolSession wanted = SampleSession("");
  ASSERT_OK_AND_ASSIGN(const FoundSession first, FindOrCreateSession(*spool_, wanted));
  EXPECT_FALSE(first.resumed);
  EXPECT_TRUE(IsValidResourceId(first.id.value()));
  ASSERT_OK_AND_ASSIGN(const FoundSession again, FindOrCreateSession(*spool_, wanted));
  EXPECT_TRUE(again.resumed);
  EXPECT_EQ(again.id, first.id);

  wanted.map = "another hall";
  ASSERT_OK_AND_ASSIGN(const FoundSession other, FindOrCreateSession(*spool_, wanted));
  EXPECT_FALSE(other.resumed);
  wanted.id = first.id;
  EXPECT_STATUS(FindOrCreateSession(*spool_, wanted), absl::StatusCode::kFailedPrecondition,
                HasSubstr("only with the same log, map, robot"));
  wanted.map = "hall";
  EXPECT_TRUE(FindOrCreateSession(*spool_, wanted)->resumed);

  ASSERT_OK(spool_->MarkFinished(first.id));
  ASSERT_OK(spool_->MarkClosed(first.id));
  wanted.id = SessionId();
  EXPECT_NE(FindOrCreateSession(*spool_, wanted)->id, first.id) << "a closed one is resumed only by its id";
}

TEST_F(ReplayTest, KeepsItsSpoolInTheStateFolder) {
  setenv("XDG_STATE_HOME", files_.path().c_str(), 1);
  ASSERT_OK_AND_ASSIGN(const std::string path, DefaultSpoolPath("replay-run-1"));
  EXPECT_EQ(path, (files_.path() / "enfilade/replay-run-1.spool").string());
  EXPECT_TRUE(std::filesystem::is_directory(files_.path() / "enfilade"));
  files_.Write("file", "");
  setenv("XDG_STATE_HOME", (files_.path() / "file").c_str(), 1);
  EXPECT_STATUS(DefaultSpoolPath("replay-run-1"), absl::StatusCode::kFailedPrecondition, HasSubstr("--spool"));
  unsetenv("XDG_STATE_HOME");
}

TEST(ReplayReport, ReportsTheSameToProgramsAndPeople) {
  ReplayOptions options;
  options.log = "a.clf";
  options.map = "hall";
  ReplayResult result;
  result.session = kRun;
  result.log.entries = 100;
  result.log.counts.scans = 40;
  result.log.facts.range_max = 81.83F;
  result.resumed_after = 20;
  result.seconds = 2.0;
  result.uplink.quarantined = 3;
  const nlohmann::json document = ReplayToJson(options, result);
  EXPECT_EQ(document["records_per_s"], 40.0);
  EXPECT_EQ(document["range_max_m"].dump(), "81.83");
  EXPECT_FALSE(document.contains("mapped"));
  std::ostringstream out;
  PrintReplay(out, options, result);
  EXPECT_THAT(out.str(),
              HasSubstr("session run-1: 100 records (40 scans) acknowledged, 20 of them by an earlier run; 80 "
                        "in 2.00 s, 40/s"));
  EXPECT_THAT(out.str(), HasSubstr("refused 3 records"));
}

}  // namespace
}  // namespace enfilade::cli

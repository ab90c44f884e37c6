// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/record_store.h"

#include <algorithm>
#include <random>
#include <thread>

#include "fmt/format.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class RecordStoreTest : public StoreContractTest {
 protected:
  std::vector<sensor::Record> ReadAll(const SessionId& session) {
    const auto records = records_.Read(Soon(), site_, session, 1, 1 << 30);
    EXPECT_OK(records);
    return records.ok() ? *records : std::vector<sensor::Record>();
  }
  storage::Session Get(const SessionId& id) {
    const auto session = sessions_.Get(Soon(), site_, id);
    EXPECT_OK(session);
    return *session;
  }
};

TEST_F(RecordStoreTest, RefusesASequenceFarBeyondTheAcknowledgedOne) {
  const SessionId session = NewSession("s1");
  const auto refused = Append(session, {ScanRecord(1), ScanRecord(storage::kMaxSequenceDistance + 1)});
  EXPECT_STATUS(refused.status(), absl::StatusCode::kInvalidArgument, HasSubstr("beyond the acknowledged 0"));
  EXPECT_EQ(Get(session).highest_sequence, 0) << "nothing of the batch is stored";
  EXPECT_OK(Append(session, {ScanRecord(storage::kMaxSequenceDistance)}));
}

TEST_F(RecordStoreTest, GivesBackEveryKindOfRecordExactly) {
  const SessionId session = NewSession("s1");
  const TestBlob image("an image");
  const TestBlob cloud("a cloud");
  sensor::Record no_returns = ScanRecord(5);
  std::get<sensor::LaserScan>(no_returns.payload).ranges = {std::numeric_limits<float>::infinity(), -1.0F, 0.0F};
  const std::vector<sensor::Record> records = {
      ScanRecord(1),
      OdometryRecord(2),
      ImageRecord(3, image.ref()),
      {4, sensor::PointCloud{4 * kNsPerSecond, sensor::CloudEncoding::kXyz32, cloud.ref()}},
      no_returns,
      WithheldRecord(6)};
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult result, Append(session, records, {image.view(), cloud.view()}));
  EXPECT_EQ(result.acknowledged_sequence, 6);
  EXPECT_EQ(result.inserted, 6);
  EXPECT_EQ(result.duplicates, 0);
  EXPECT_EQ(ReadAll(session), records);
  const storage::Session stored = Get(session);
  EXPECT_EQ(stored.record_counts, (storage::RecordCounts{2, 1, 1, 1, 1}));
  EXPECT_EQ(stored.first_time, kNsPerSecond);
  EXPECT_EQ(stored.last_time, 5 * kNsPerSecond);
  EXPECT_GT(stored.payload_bytes, 0);
}

TEST_F(RecordStoreTest, TheSameRecordsAgainAreDuplicates) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 10)));
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult again, Append(session, ScanRecords(1, 10)));
  EXPECT_EQ(again.duplicates, 10);
  EXPECT_EQ(again.inserted, 0);
  EXPECT_EQ(again.acknowledged_sequence, 10);
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult overlapping, Append(session, ScanRecords(6, 15)));
  EXPECT_EQ(overlapping.duplicates, 5);
  EXPECT_EQ(overlapping.inserted, 5);
  EXPECT_EQ(overlapping.acknowledged_sequence, 15);
  EXPECT_EQ(ReadAll(session), ScanRecords(1, 15));
  EXPECT_EQ(Get(session).record_counts.laser_scans, 15);
}

TEST_F(RecordStoreTest, ScansWithNanAreDuplicatesOfThemselves) {
  const SessionId session = NewSession("s1");
  sensor::Record record = ScanRecord(1);
  std::get<sensor::LaserScan>(record.payload).ranges[1] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_OK(Append(session, {record}));
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult again, Append(session, {record}));
  EXPECT_EQ(again.duplicates, 1);
}

TEST_F(RecordStoreTest, AnotherContentUnderAStoredSequenceRefusesTheWholeBatch) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 5)));
  std::vector<sensor::Record> records = ScanRecords(1, 8);
  records[2] = OdometryRecord(3);
  const auto refused = Append(session, records);
  EXPECT_STATUS(refused, absl::StatusCode::kAlreadyExists, HasSubstr("record 3 of sites/campus/sessions/s1"));
  EXPECT_EQ(storage::RefusedSequenceOf(refused.status()), 3);
  EXPECT_EQ(Get(session).acknowledged_sequence, 5);
  std::get<sensor::LaserScan>((records = ScanRecords(1, 8))[4].payload).ranges[0] += 0.001F;
  EXPECT_EQ(storage::RefusedSequenceOf(Append(session, records).status()), 5);
  EXPECT_EQ(ReadAll(session), ScanRecords(1, 5));
}

TEST_F(RecordStoreTest, AcknowledgesUpToTheFirstHole) {
  const SessionId session = NewSession("s1");
  const auto acknowledged = [&](std::int64_t first, std::int64_t last) {
    const auto result = Append(session, ScanRecords(first, last));
    EXPECT_OK(result);
    return result.ok() ? result->acknowledged_sequence : -1;
  };
  EXPECT_EQ(acknowledged(3, 4), 0);
  EXPECT_THAT(ReadAll(session), IsEmpty());
  EXPECT_EQ(acknowledged(1, 1), 1);
  EXPECT_EQ(acknowledged(8, 9), 1);
  EXPECT_EQ(acknowledged(2, 2), 4);
  EXPECT_EQ(acknowledged(6, 6), 4);
  EXPECT_EQ(ReadAll(session), ScanRecords(1, 4));
  EXPECT_EQ(acknowledged(5, 7), 9);  // 6 was there: fills both holes
  EXPECT_EQ(ReadAll(session), ScanRecords(1, 9));
  EXPECT_EQ(Get(session).record_counts.laser_scans, 9);
}

TEST_F(RecordStoreTest, AnyOrderOfBatchesEndsTheSame) {
  const std::vector<sensor::Record> log = ScanRecords(1, 60);
  std::mt19937 random(7);
  for (int round = 0; round < 10; ++round) {
    const SessionId session = NewSession(fmt::format("s{}", round));
    std::vector<std::pair<std::size_t, std::size_t>> pieces;  // overlapping, so that some come twice
    for (std::size_t first = 0; first < log.size(); first += 3) {
      pieces.emplace_back(first, std::min(first + 3 + random() % 3, log.size()));
    }
    std::shuffle(pieces.begin(), pieces.end(), random);
    std::int64_t inserted = 0;
    std::int64_t acknowledged = 0;
    for (const auto& [first, last] : pieces) {
      ASSERT_OK_AND_ASSIGN(const storage::AppendResult result,
                           Append(session, {log.begin() + static_cast<std::ptrdiff_t>(first),
                                            log.begin() + static_cast<std::ptrdiff_t>(last)}));
      inserted += result.inserted;
      EXPECT_GE(result.acknowledged_sequence, acknowledged);
      acknowledged = result.acknowledged_sequence;
    }
    EXPECT_EQ(inserted, 60);
    EXPECT_EQ(acknowledged, 60);
    EXPECT_EQ(ReadAll(session), log);
  }
}

TEST_F(RecordStoreTest, RefusesSequencesThatDoNotIncrease) {
  const SessionId session = NewSession("s1");
  const auto repeated = Append(session, {ScanRecord(1), ScanRecord(2), ScanRecord(2)});
  EXPECT_CODE(repeated, absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(storage::RefusedSequenceOf(repeated.status()), 2);
  EXPECT_CODE(Append(session, {ScanRecord(0)}), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(backend_->CountRecords(), 0);
}

TEST_F(RecordStoreTest, AnEmptyBatchReportsWhereTheLogStands) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 3)));
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult result, Append(session, {}));
  EXPECT_EQ(result.acknowledged_sequence, 3);
}

TEST_F(RecordStoreTest, AFinishedSessionTakesOnlyWhatItHas) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 3)));
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 3));
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult again, Append(session, ScanRecords(2, 3)));
  EXPECT_EQ(again.duplicates, 2);
  EXPECT_STATUS(Append(session, ScanRecords(3, 4)), absl::StatusCode::kFailedPrecondition, HasSubstr("is finished"));
  EXPECT_EQ(ReadAll(session), ScanRecords(1, 3));
}

TEST_F(RecordStoreTest, LateRecordsOfADeletedSessionAreRefused) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 3)));
  ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  EXPECT_STATUS(Append(session, ScanRecords(4, 5)), absl::StatusCode::kFailedPrecondition,
                HasSubstr("sites/campus/sessions/s1 is deleted"));
  EXPECT_CODE(Append(session, ScanRecords(1, 3)), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(Append(SessionId("s9"), ScanRecords(1, 3)), absl::StatusCode::kNotFound);
}

TEST_F(RecordStoreTest, RefusesARecordWhoseBlobIsMissingOrOfAnotherSize) {
  const SessionId session = NewSession("s1");
  const TestBlob blob("image");
  const auto missing = Append(session, {ScanRecord(1), ImageRecord(2, blob.ref())});
  EXPECT_STATUS(missing, absl::StatusCode::kInvalidArgument, HasSubstr("record 2"));
  EXPECT_EQ(storage::RefusedSequenceOf(missing.status()), 2);
  sensor::BlobRef longer = blob.ref();
  longer.size = 6;
  const auto wrong_size = Append(session, {ImageRecord(1, longer)}, {blob.view()});
  EXPECT_STATUS(wrong_size, absl::StatusCode::kInvalidArgument, HasSubstr("has 5 bytes, not 6"));
  EXPECT_CODE(Append(session, {ScanRecord(1)}, {{blob.sha256(), "evil"}}), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(backend_->CountRecords(), 0);
  ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view()}));
  EXPECT_OK(Append(session, {ImageRecord(1, blob.ref()), ImageRecord(2, blob.ref())}));
  EXPECT_EQ(backend_->CountBlobs(), 1);
}

TEST_F(RecordStoreTest, ARefusedBatchDoesNotTouchTheOthersOfItsGroup) {
  backend_->AddSite(SiteId("other"));
  backend_->AddRobot(SiteId("other"), robot_);
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(SiteId("other"), SessionId("s1"), robot_, std::nullopt), ""));
  const SiteId other("other");
  const SessionId first = NewSession("s1");
  const SessionId second = NewSession("s2");
  const SessionId missing("s9");
  const auto a = ScanRecords(1, 3);
  const auto b = ScanRecords(4, 6);
  auto changed = ScanRecords(3, 8);
  changed[0] = OdometryRecord(3);
  const auto late = ScanRecords(2, 7);
  const std::vector<storage::RecordBatch> batches = {
      {site_, first, a, {}}, {site_, missing, a, {}},     {other, first, a, {}},   {site_, second, b, {}},
      {site_, first, b, {}}, {site_, first, changed, {}}, {site_, first, late, {}}};
  const auto answers = records_.AppendGroup(Soon(), batches);
  ASSERT_THAT(answers, SizeIs(7));
  ASSERT_OK(answers[0]);
  EXPECT_CODE(answers[1], absl::StatusCode::kNotFound);
  ASSERT_OK(answers[2]);
  EXPECT_EQ(answers[2]->acknowledged_sequence, 3);
  ASSERT_OK(answers[3]);
  EXPECT_EQ(answers[3]->acknowledged_sequence, 0);
  ASSERT_OK(answers[4]);
  EXPECT_CODE(answers[5], absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(storage::RefusedSequenceOf(answers[5].status()), 3);
  ASSERT_OK(answers[6]);
  EXPECT_EQ(answers[6]->duplicates, 5);
  EXPECT_EQ(answers[6]->inserted, 1);
  EXPECT_EQ(answers[6]->acknowledged_sequence, 7);
  EXPECT_EQ(ReadAll(first), ScanRecords(1, 7));
  EXPECT_EQ(Get(second).highest_sequence, 6);
}

TEST_F(RecordStoreTest, ManyWritersOfOneSessionStoreEachRecordOnce) {
  const SessionId session = NewSession("s1");
  const std::vector<sensor::Record> log = ScanRecords(1, 200);
  std::vector<absl::Status> outcomes(6);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < outcomes.size(); ++t) {
    threads.emplace_back([&, t] {
      std::mt19937 random(static_cast<unsigned>(t));
      for (std::size_t first = 0; first < log.size() && outcomes[t].ok();) {
        const std::size_t count = std::min<std::size_t>(1 + random() % 20, log.size() - first);
        outcomes[t] =
            records_.Append(Soon(), {site_, session, absl::MakeConstSpan(log).subspan(first, count), {}}).status();
        first += count;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const absl::Status& outcome : outcomes) EXPECT_OK(outcome);
  EXPECT_EQ(ReadAll(session), log);
  EXPECT_EQ(Get(session).record_counts.laser_scans, 200);
}

TEST_F(RecordStoreTest, ReadsInPortionsOfAboutTheGivenSize) {
  const SessionId session = NewSession("s1");
  std::vector<sensor::Record> log;
  for (std::int64_t sequence = 1; sequence <= 100; ++sequence) {
    log.push_back(sequence % 10 == 0 ? ScanRecord(sequence, 10'000) : OdometryRecord(sequence));
  }
  ASSERT_OK(Append(session, log));
  std::vector<sensor::Record> all;
  std::size_t largest = 0;
  while (all.size() < log.size()) {
    ASSERT_OK_AND_ASSIGN(const auto records,
                         records_.Read(Soon(), site_, session, static_cast<std::int64_t>(all.size()) + 1, 50'000));
    ASSERT_THAT(records, ::testing::Not(IsEmpty()));
    std::size_t bytes = 0;
    for (const sensor::Record& record : records)
      bytes += std::holds_alternative<sensor::LaserScan>(record.payload) ? 40'000 : 40;
    largest = std::max(largest, bytes);
    all.insert(all.end(), records.begin(), records.end());
  }
  EXPECT_EQ(all, log);
  EXPECT_LE(largest, 100'000U);
  ASSERT_OK_AND_ASSIGN(const auto beyond, records_.Read(Soon(), site_, session, 101, 50'000));
  EXPECT_THAT(beyond, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto one, records_.Read(Soon(), site_, session, 10, 1));
  EXPECT_THAT(one, SizeIs(1));
}

TEST_F(RecordStoreTest, ReadsSingleRecordsInTheOrderOfTheLog) {
  const SessionId session = NewSession("s1");
  const std::vector<sensor::Record> log = ScanRecords(1, 10);
  ASSERT_OK(Append(session, log));
  ASSERT_OK_AND_ASSIGN(const auto some, records_.ReadEach(Soon(), site_, session, {7, 2, 99}));
  EXPECT_EQ(some, (std::vector<sensor::Record>{log[1], log[6]}));
  ASSERT_OK_AND_ASSIGN(const auto none, records_.ReadEach(Soon(), site_, session, {}));
  EXPECT_THAT(none, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto missing, records_.ReadEach(Soon(), site_, SessionId("s9"), {1}));
  EXPECT_THAT(missing, IsEmpty());
  backend_->CorruptRecord(site_, session, 2);
  EXPECT_STATUS(records_.ReadEach(Soon(), site_, session, {2}), absl::StatusCode::kDataLoss, HasSubstr("record 2"));
}

TEST_F(RecordStoreTest, SaysWhenAStoredPayloadDoesNotDecode) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 2)));
  backend_->CorruptRecord(site_, session, 2);
  EXPECT_STATUS(records_.Read(Soon(), site_, session, 1, 1 << 20), absl::StatusCode::kDataLoss, HasSubstr("record 2"));
}

TEST_F(RecordStoreTest, SelectsByKindTimeAndSequence) {
  const SessionId session = NewSession("s1");
  std::vector<sensor::Record> log;
  for (std::int64_t sequence = 1; sequence <= 20; ++sequence) {
    log.push_back(sequence % 2 == 0 ? ScanRecord(sequence) : OdometryRecord(sequence));
  }
  ASSERT_OK(Append(session, log));
  const storage::RecordSelection all{
      {sensor::RecordKind::kLaserScan, sensor::RecordKind::kOdometry}, 0, 100 * kNsPerSecond, 1, 20};
  struct Case {
    std::string name;
    storage::RecordSelection selection;
    std::vector<std::int64_t> expected;
  };
  std::vector<Case> cases;
  cases.push_back({"limits are inclusive", all, {5, 6, 7}});
  cases.back().selection.first_sequence = 5;
  cases.back().selection.last_sequence = 7;
  cases.push_back({"times, too", all, {3, 4}});
  cases.back().selection.from_time = 3 * kNsPerSecond;
  cases.back().selection.to_time = 4 * kNsPerSecond;
  cases.push_back({"just outside", all, {4}});
  cases.back().selection.from_time = 3 * kNsPerSecond + 1;
  cases.back().selection.to_time = 5 * kNsPerSecond - 1;
  cases.push_back({"one kind", all, {18, 20}});
  cases.back().selection.kinds = {sensor::RecordKind::kLaserScan};
  cases.back().selection.first_sequence = 17;
  cases.push_back({"a kind that is not there", all, {}});
  cases.back().selection.kinds = {sensor::RecordKind::kImage};
  cases.push_back({"no kind", all, {}});
  cases.back().selection.kinds = {};
  cases.push_back({"beyond the log", all, {}});
  cases.back().selection.first_sequence = 21;
  cases.back().selection.last_sequence = 99;
  for (const Case& test : cases) {
    ASSERT_OK_AND_ASSIGN(const auto records, records_.ReadSelected(Soon(), site_, session, test.selection));
    std::vector<std::int64_t> sequences;
    for (const sensor::Record& record : records) {
      sequences.push_back(record.sequence);
      EXPECT_EQ(record, log[static_cast<std::size_t>(record.sequence) - 1]) << test.name;
    }
    EXPECT_EQ(sequences, test.expected) << test.name;
  }
  ASSERT_OK_AND_ASSIGN(const auto missing, records_.ReadSelected(Soon(), site_, SessionId("s9"), all));
  EXPECT_THAT(missing, IsEmpty());
  backend_->CorruptRecord(site_, session, 2);
  EXPECT_CODE(records_.ReadSelected(Soon(), site_, session, all), absl::StatusCode::kDataLoss);
}

TEST_F(RecordStoreTest, WhatIsBeyondAHoleCanBeSelectedButNotRead) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, {OdometryRecord(1), OdometryRecord(3)}));
  EXPECT_THAT(ReadAll(session), SizeIs(1));
  ASSERT_OK_AND_ASSIGN(const auto each, records_.ReadEach(Soon(), site_, session, {1, 2, 3}));
  EXPECT_EQ(each, (std::vector<sensor::Record>{OdometryRecord(1), OdometryRecord(3)}));
}

TEST_F(RecordStoreTest, AfterRetentionOldRecordsCountAsStoredAndNewOnesAreTaken) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 5)));
  backend_->ExpireRecords(site_, session);
  EXPECT_STATUS(records_.Read(Soon(), site_, session, 1, 1 << 20), absl::StatusCode::kFailedPrecondition,
                HasSubstr("retention"));
  // What they were is no longer known: a robot that sends them again must not be refused.
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult again, Append(session, {OdometryRecord(2), ScanRecord(5)}));
  EXPECT_EQ(again.duplicates, 2);
  EXPECT_EQ(again.acknowledged_sequence, 5);
  ASSERT_OK_AND_ASSIGN(const storage::AppendResult next, Append(session, {ScanRecord(5), ScanRecord(6)}));
  EXPECT_EQ(next.inserted, 1);
  EXPECT_EQ(next.acknowledged_sequence, 6);
  EXPECT_TRUE(Get(session).records_deleted);
}

TEST_F(RecordStoreTest, CountsRecordsByKindAndTheirTimes) {
  const SessionId session = NewSession("s1");
  const TestBlob image("image");
  sensor::DoorReport report;
  report.time = 90 * kNsPerSecond;
  ASSERT_OK(Append(session, {WithheldRecord(1)}));
  EXPECT_EQ(Get(session).first_time, std::nullopt) << "a withheld record has no time";
  ASSERT_OK(Append(session, {ScanRecord(50), OdometryRecord(51), ImageRecord(52, image.ref()), {53, report}},
                   {image.view()}));
  ASSERT_OK(Append(session, {OdometryRecord(7)}));
  storage::RecordCounts counts;
  counts.laser_scans = counts.images = counts.withheld = counts.door_reports = 1;
  counts.odometry = 2;
  EXPECT_EQ(Get(session).record_counts, counts);
  EXPECT_EQ(Get(session).first_time, 7 * kNsPerSecond);
  EXPECT_EQ(Get(session).last_time, 90 * kNsPerSecond);
  EXPECT_EQ(Get(session).highest_sequence, 53);
  EXPECT_EQ(Get(session).acknowledged_sequence, 1);
}

}  // namespace
}  // namespace enfilade::testing

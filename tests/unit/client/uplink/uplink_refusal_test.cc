// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/client/uplink/uplink_fixture.h"

namespace enfilade::client {
namespace {

using client::SpoolSession;
using testing::FakeServer;
using ::testing::HasSubstr;
using testing::kRun;
using testing::kRunName;
using testing::Moment;
using testing::NumberedScan;
using testing::SampleSession;
using testing::UplinkTest;

TEST_F(UplinkTest, PutsRefusedRecordsAsideAndSendsTheRest) {
  const std::set<std::int64_t> bad = {1, 2, 77, 78, 110, 299, 300};
  FakeServer::Behaviour behaviour;
  behaviour.refuse = [&](const v1::Record& record) -> std::optional<std::string> {
    if (!bad.contains(record.sequence()) || record.has_withheld()) return std::nullopt;
    return "record " + std::to_string(record.sequence()) + ": I do not like it";
  };
  Serve(behaviour);
  RecordAll(300);
  ASSERT_OK(Bring());
  ExpectAllStored(bad);
  EXPECT_EQ(progress_.quarantined, 7);
  ASSERT_OK_AND_ASSIGN(const auto kept, spool_->ListQuarantined(kRun));
  ASSERT_EQ(kept.size(), bad.size());
  EXPECT_EQ(kept[2].record, (enfilade::sensor::Record{77, NumberedScan(77, 30)}));
  EXPECT_EQ(kept[2].reason, "record 77: I do not like it");
}

TEST_F(UplinkTest, EndsWhereEvenTheWithheldRecordIsRefused) {
  FakeServer::Behaviour behaviour;
  behaviour.refuse = [](const v1::Record& record) -> std::optional<std::string> {
    return record.sequence() == 30 ? std::optional<std::string>("never") : std::nullopt;
  };
  Serve(behaviour);
  RecordAll(100);
  EXPECT_STATUS(Bring(), absl::StatusCode::kFailedPrecondition, HasSubstr("record 30 was refused (never)"));
}

TEST_F(UplinkTest, EndsWithThePermanentErrorsAndKeepsTheSpool) {
  FakeServer::Behaviour behaviour;
  behaviour.interfere = [](Moment moment, int count) {
    if (moment != Moment::kBatchReceived || count < 3) return grpc::Status::OK;
    return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION, "the session is deleted");
  };
  Serve(behaviour);
  RecordAll(100);
  EXPECT_STATUS(Bring(), absl::StatusCode::kFailedPrecondition, HasSubstr("the session is deleted"));
  EXPECT_EQ(spool_->FindSession(kRun)->last_sequence, 100);
  EXPECT_GE(spool_->usage().records, 60);
}

TEST_F(UplinkTest, EndsWhereAnotherRobotRecordsUnderTheSameSession) {
  Serve();
  RecordAll(10);
  ASSERT_OK(Bring());
  server_->Edit(kRunName, [](FakeServer::Session& session) { session.session.set_robot("sites/campus/robots/other"); });
  ASSERT_OK(spool_->RemoveSession(kRun));
  SpoolSession again = SampleSession();
  again.request_id = "99999999-2222-4333-8444-555555555555";
  ASSERT_OK(spool_->CreateSession(again));
  EXPECT_STATUS(Bring(), absl::StatusCode::kAlreadyExists, HasSubstr("sites/campus/robots/other records it"));
}

TEST_F(UplinkTest, GoesOnWithANewDiskWhereTheServerHasMoreThanTheSpool) {
  Serve();
  Record(100);
  ASSERT_OK(spool_->MarkFinished(kRun));
  ASSERT_OK(Bring());
  // The same recording again, from a spool that knows of nothing.
  ASSERT_OK(spool_->RemoveSession(kRun));
  SpoolSession again = SampleSession();
  again.request_id = "99999999-2222-4333-8444-555555555555";
  ASSERT_OK(spool_->CreateSession(again));
  recorded_ = 0;
  RecordAll(150);
  ASSERT_OK(Bring());
  ExpectAllStored();
}

TEST_F(UplinkTest, EndsOnConflictingRecords) {
  Serve();
  Record(20);
  options_.create_missing = true;
  server_->Edit(kRunName, [](FakeServer::Session& session) {
    session.request_id = SampleSession().request_id;
    session.records[5] = convert::ToProto(enfilade::sensor::Record{5, NumberedScan(999, 30)});
  });
  EXPECT_STATUS(Bring(), absl::StatusCode::kAlreadyExists, HasSubstr("two robots"));
}

TEST_F(UplinkTest, EndsWhereTheServerHasLostWhatItAcknowledged) {
  Serve();
  Record(100);
  {
    Uplink uplink(Connection(server_->address(), std::chrono::seconds(20)), *spool_, kRun, options_);
    uplink.Start();
    while (spool_->usage().records > 0) std::this_thread::yield();
  }
  server_->Edit(kRunName, [](FakeServer::Session& session) { session.records.erase(50); });
  EXPECT_STATUS(Bring(), absl::StatusCode::kDataLoss, HasSubstr("up to 49, but it acknowledged up to 100"));
}

TEST_F(UplinkTest, CreatesNothingWhereThatIsNotWanted) {
  Serve();
  options_.create_missing = false;
  RecordAll(5);
  EXPECT_STATUS(Bring(), absl::StatusCode::kNotFound, HasSubstr("has no map \"hall\""));
  EXPECT_TRUE(server_->maps().empty());
}

}  // namespace
}  // namespace enfilade::client

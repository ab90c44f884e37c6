// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <optional>
#include <random>
#include <thread>

#include "fmt/format.h"
#include "tests/unit/server/app/ingest/ingest_fixture.h"

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST_F(IngestTest, AcknowledgesOnlyAfterTheCommit) {
  Start();
  Client client(*ingest_, NewSession("s"));
  records_.Hold();
  EXPECT_TRUE(client.Send(1, 10));
  records_.AwaitTransactions(1);
  EXPECT_THAT(client.events(), IsEmpty());
  EXPECT_EQ(stored_, 0);
  EXPECT_EQ(Acknowledged("s"), 0);
  records_.LetGo();
  EXPECT_THAT(client.AwaitEvents(1), ElementsAre("stored 10"));
  EXPECT_EQ(Acknowledged("s"), 10);
  EXPECT_EQ(stored_, 1);
}

TEST_F(IngestTest, WhileOneTransactionIsWrittenTheNextOneGathers) {
  Start();
  Client a(*ingest_, NewSession("a"));
  Client b(*ingest_, NewSession("b"));
  records_.Hold();
  a.Send(1, 2);
  records_.AwaitTransactions(1);
  a.Send(3, 4);
  b.Send(1, 3);
  a.Send(5, 6);
  records_.LetGo();
  a.Await("stored 6");
  b.Await("stored 3");
  EXPECT_THAT(records_.AwaitTransactions(2),
              ElementsAre(ElementsAre("a:1"), UnorderedElementsAre("b:1", "a:3", "a:5")));
}

TEST_F(IngestTest, ATransactionIsBoundedInBytesAndStreams) {
  options_.transaction_bytes = 100;
  Start();
  std::vector<std::unique_ptr<Client>> clients;
  records_.Hold();
  clients.push_back(std::make_unique<Client>(*ingest_, NewSession("first")));
  clients[0]->Send(1, 1);
  records_.AwaitTransactions(1);
  for (std::int64_t i = 0; i < 4; ++i) clients[0]->Send(2 + i, 2 + i, 60);
  for (int i = 0; i < 40; ++i) {
    clients.push_back(std::make_unique<Client>(*ingest_, NewSession(fmt::format("s{}", i))));
    clients.back()->Send(1, 1, 1);
  }
  records_.LetGo();
  clients[0]->Await("stored 5");
  for (std::size_t i = 1; i < clients.size(); ++i) clients[i]->Await("stored 1");
  const auto transactions = records_.AwaitTransactions(1);
  // 60 + 60 bytes of the first stream reach the bound; 32 streams of one byte are as many as share a transaction.
  for (const auto& transaction : transactions) {
    EXPECT_LE(transaction.size(), 33U);
    EXPECT_LE(std::count_if(transaction.begin(), transaction.end(),
                            [](const std::string& batch) { return batch.starts_with("first"); }),
              2);
  }
  EXPECT_GE(transactions.size(), 4U);
}

TEST_F(IngestTest, EventsComeInTheOrderOfTheItems) {
  Start();
  Client client(*ingest_, NewSession("s"));
  records_.Hold();
  client.Send(1, 1);
  records_.AwaitTransactions(1);  // the following ones go into one round
  client.Send(2, 3);
  client.Offer(Refusal{4, 5, Refusal::Reason::kInvalidRecord, "no ranges"});
  client.Send(4, 4);
  records_.LetGo();
  // All batches of a session in one transaction are acknowledged up to its end.
  EXPECT_THAT(client.AwaitEvents(4), ElementsAre("stored 1", "stored 4", "refused 5 of 4: invalid record", "stored 4"));
}

TEST_F(IngestTest, RefusesABatchWithARecordThatConflictsOrIsInvalid) {
  Start();
  Client client(*ingest_, NewSession("s"));
  client.Send(1, 3);
  client.Await("stored 3");
  std::vector<sensor::Record> other = OdometryRecords(2, 4);
  std::get<sensor::Odometry>(other[0].payload).T_odom_robot.x += 1.0;
  client.Offer(IngestBatch{other});
  client.AwaitEvents(2);
  const sensor::Image image{kNsPerSecond, sensor::Camera::kFront, sensor::ImageEncoding::kPng, {Sha256("missing"), 7}};
  client.Offer(IngestBatch{{OdometryRecord(4), {5, image}}});
  EXPECT_THAT(client.AwaitEvents(3),
              ElementsAre("stored 3", "refused 2 of 2: conflicting", "refused 5 of 4: invalid record"));
  EXPECT_EQ(Acknowledged("s"), 3) << "nothing of a refused batch is stored";
  client.Send(4, 5);
  client.Await("stored 5");
}

TEST_F(IngestTest, RecordsThatAreSentAgainAreAcknowledgedAndNotNew) {
  Start();
  Client client(*ingest_, NewSession("s"));
  client.Send(1, 4);
  client.Await("stored 4");
  client.Send(1, 4);
  EXPECT_THAT(client.AwaitEvents(2), ElementsAre("stored 4", "stored 4"));
  client.Send(3, 6);
  client.Await("stored 6");
  EXPECT_EQ(stored_, 2) << "nothing to map after a batch of duplicates";
}

TEST_F(IngestTest, ABlobIsStoredBeforeTheRecordThatRefersToIt) {
  Start();
  Client client(*ingest_, NewSession("s"));
  const std::string content = "an image";
  const sensor::BlobRef ref{Sha256(content), static_cast<std::int64_t>(content.size())};
  records_.Hold();
  client.Send(1, 1);
  records_.AwaitTransactions(1);
  client.Offer(IngestBlob{ref.sha256, Uploaded(content)});
  client.Offer(
      IngestBatch{{{2, sensor::Image{kNsPerSecond, sensor::Camera::kFront, sensor::ImageEncoding::kPng, ref}}}});
  records_.LetGo();
  EXPECT_THAT(client.AwaitEvents(2), ElementsAre("stored 1", "stored 2"));
  EXPECT_EQ(stores_.database.CountBlobs(), 1);
}

TEST_F(IngestTest, ABlobThatCannotBeStoredFailsTheStream) {
  Start();
  Client client(*ingest_, NewSession("s"));
  client.Offer(IngestBlob{Sha256("something else"), Uploaded("a blob")});
  EXPECT_THAT(client.AwaitEvents(1), ElementsAre("INVALID_ARGUMENT"));
}

TEST_F(IngestTest, AFailedTransactionFailsItsStreamsAndNoOthers) {
  Start();
  Client a(*ingest_, NewSession("a"));
  Client b(*ingest_, NewSession("b"));
  records_.Hold();
  records_.FailNext(absl::UnavailableError("the database is gone"));
  a.Send(1, 2);
  records_.AwaitTransactions(1);
  a.Send(3, 4);  // queued behind the failure: must not be stored with a gap before it
  b.Send(1, 2);
  records_.LetGo();
  a.Await("UNAVAILABLE");
  b.Await("stored 2");
  a.Send(5, 6);
  a.Close();
  b.Send(3, 3);
  b.Await("stored 3");
  EXPECT_THAT(a.events(), ElementsAre("UNAVAILABLE"));
  EXPECT_EQ(stores_.database.CountRecords(), 3);
  // The client opens another stream and sends again what was not acknowledged.
  Client again(*ingest_, "a");
  again.Send(1, 6);
  again.Await("stored 6");
}

TEST_F(IngestTest, ASessionThatTakesNoRecordsFailsTheStream) {
  Start();
  NewSession("s");
  ASSERT_OK(stores_.sessions.Finish(Soon(), kSite, SessionId("s"), 0));
  Client finished(*ingest_, "s");
  finished.Send(1, 1);
  EXPECT_THAT(finished.AwaitEvents(1), ElementsAre("FAILED_PRECONDITION"));
  Client missing(*ingest_, "nowhere");
  missing.Send(1, 1);
  EXPECT_THAT(missing.AwaitEvents(1), ElementsAre("NOT_FOUND"));
}

}  // namespace
}  // namespace enfilade::server

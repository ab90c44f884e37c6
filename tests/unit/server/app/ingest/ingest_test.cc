// SPDX-License-Identifier: Apache-2.0
#include "server/app/ingest/ingest.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <random>
#include <thread>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

const SiteId kSite("campus");

// A record store that can hold back its transactions, fail them, and that remembers them.
class HeldRecordStore final : public storage::RecordStore {
 public:
  explicit HeldRecordStore(const storage::RecordStore& store) : store_(store) {}

  std::vector<absl::StatusOr<storage::AppendResult>> AppendGroup(
      const storage::CallContext& context, absl::Span<const storage::RecordBatch> batches) const override {
    absl::Status failure;
    {
      MutexLock lock(mutex_);
      std::vector<std::string>& transaction = transactions_.emplace_back();
      for (const storage::RecordBatch& batch : batches) {
        transaction.push_back(fmt::format("{}:{}", batch.session.value(), batch.records.front().sequence));
      }
      changed_.NotifyAll();
      while (held_) changed_.Wait(mutex_);
      failure = std::exchange(failure_, absl::OkStatus());
    }
    if (failure.ok()) return store_.AppendGroup(context, batches);
    return {batches.size(), failure};
  }
  absl::StatusOr<std::vector<sensor::Record>> Read(const storage::CallContext& context, const SiteId& site,
                                                   const SessionId& session, std::int64_t from_sequence,
                                                   std::int64_t max_bytes) const override {
    return store_.Read(context, site, session, from_sequence, max_bytes);
  }
  absl::StatusOr<std::vector<sensor::Record>> ReadSelected(const storage::CallContext& context, const SiteId& site,
                                                           const SessionId& session,
                                                           const storage::RecordSelection& selection) const override {
    return store_.ReadSelected(context, site, session, selection);
  }
  absl::StatusOr<std::vector<sensor::Record>> ReadEach(const storage::CallContext& context, const SiteId& site,
                                                       const SessionId& session,
                                                       const std::vector<std::int64_t>& sequences) const override {
    return store_.ReadEach(context, site, session, sequences);
  }

  void Hold() {
    MutexLock lock(mutex_);
    held_ = true;
  }
  void LetGo() {
    MutexLock lock(mutex_);
    held_ = false;
    changed_.NotifyAll();
  }
  // The next transaction fails with `failure`.
  void FailNext(absl::Status failure) {
    MutexLock lock(mutex_);
    failure_ = std::move(failure);
  }
  // The first batches of each transaction as "session:sequence", once `count` transactions have begun.
  std::vector<std::vector<std::string>> AwaitTransactions(std::size_t count) const {
    MutexLock lock(mutex_);
    while (transactions_.size() < count) changed_.Wait(mutex_);
    return transactions_;
  }

 private:
  const storage::RecordStore& store_;
  mutable Mutex mutex_;
  mutable CondVar changed_;
  mutable std::vector<std::vector<std::string>> transactions_;
  bool held_ = false;
  mutable absl::Status failure_;
};

std::string Describe(const IngestEvent& event) {
  if (const auto* stored = std::get_if<Stored>(&event)) return fmt::format("stored {}", stored->acknowledged_sequence);
  if (const auto* refusal = std::get_if<Refusal>(&event)) {
    const char* const reason = refusal->reason == Refusal::Reason::kConflictingRecord ? "conflicting"
                               : refusal->reason == Refusal::Reason::kInvalidRecord   ? "invalid record"
                                                                                      : "invalid batch";
    return fmt::format("refused {} of {}: {}", refusal->sequence, refusal->first_sequence, reason);
  }
  if (const auto* failed = std::get_if<Failed>(&event)) return absl::StatusCodeToString(failed->status.code());
  return std::holds_alternative<RoomAgain>(event) ? "room again" : "drained";
}

// A stream and the events that it has received.
class Client {
 public:
  Client(Ingest& ingest, const std::string& session)
      : ingest_(ingest), stream_(ingest.Open({kSite, SessionId(session)}, [this](const IngestEvent& event) {
          MutexLock lock(mutex_);
          events_.push_back(Describe(event));
          changed_.NotifyAll();
        })) {}
  ~Client() { Close(); }

  bool Send(std::int64_t first, std::int64_t last, std::size_t bytes = 1) {
    return ingest_.Offer(stream_, IngestBatch{OdometryRecords(first, last)}, bytes);
  }
  bool Offer(IngestItem item, std::size_t bytes = 1) { return ingest_.Offer(stream_, std::move(item), bytes); }
  void Close() { ingest_.Close(stream_); }

  std::vector<std::string> AwaitEvents(std::size_t count) {
    MutexLock lock(mutex_);
    while (events_.size() < count) changed_.Wait(mutex_);
    return events_;
  }
  void Await(const std::string& event) {
    MutexLock lock(mutex_);
    while (std::find(events_.begin(), events_.end(), event) == events_.end()) changed_.Wait(mutex_);
  }
  std::vector<std::string> events() {
    MutexLock lock(mutex_);
    return events_;
  }

 private:
  Ingest& ingest_;
  Mutex mutex_;
  CondVar changed_;
  std::vector<std::string> events_;
  const std::shared_ptr<Ingest::Stream> stream_;  // the last member: events come from here on
};

class IngestTest : public ::testing::Test {
 protected:
  IngestTest() {
    stores_.database.AddSite(kSite);
    stores_.database.AddRobot(kSite, RobotId("r"));
    EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(kSite, "m"), ""));
    options_.writers = 1;
  }

  std::string NewSession(const std::string& id) {
    EXPECT_OK(stores_.sessions.Create(Soon(), MakeSession(kSite, id, "m"), ""));
    return id;
  }
  void Start() {
    ingest_.emplace(options_, records_, stores_.blobs, *metrics_, [this] { ++stored_; });
  }
  std::int64_t Acknowledged(const std::string& session) {
    return stores_.sessions.Get(Soon(), kSite, SessionId(session))->acknowledged_sequence;
  }

  testing::InMemoryStores stores_;
  HeldRecordStore records_{stores_.records};
  const std::unique_ptr<Metrics> metrics_ = *Metrics::Create("");
  ServerOptions::Ingest options_;
  std::atomic<int> stored_{0};  // calls of on_stored
  std::optional<Ingest> ingest_;
};

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
  client.Offer(IngestBlob{ref.sha256, content});
  client.Offer(
      IngestBatch{{{2, sensor::Image{kNsPerSecond, sensor::Camera::kFront, sensor::ImageEncoding::kPng, ref}}}});
  records_.LetGo();
  EXPECT_THAT(client.AwaitEvents(2), ElementsAre("stored 1", "stored 2"));
  EXPECT_EQ(stores_.database.CountBlobs(), 1);
}

TEST_F(IngestTest, ABlobThatCannotBeStoredFailsTheStream) {
  Start();
  Client client(*ingest_, NewSession("s"));
  client.Offer(IngestBlob{Sha256("something else"), "a blob"});
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

TEST_F(IngestTest, AStreamAheadOfTheDatabaseWaitsForRoom) {
  options_.stream_buffer_bytes = 100;
  Start();
  Client slow(*ingest_, NewSession("slow"));
  Client other(*ingest_, NewSession("other"));
  records_.Hold();
  EXPECT_TRUE(slow.Send(1, 1, 60));
  records_.AwaitTransactions(1);
  EXPECT_FALSE(slow.Send(2, 2, 60)) << "also what is being written counts";
  EXPECT_TRUE(other.Send(1, 1, 60)) << "the bound is per stream";
  records_.LetGo();
  slow.Await("room again");
  slow.Await("stored 2");  // the item is accepted although Offer returned false
  EXPECT_TRUE(slow.Send(3, 3, 60));
  other.Await("stored 1");
  EXPECT_THAT(other.events(), ElementsAre("stored 1")) << "it did not have to wait";
}

TEST_F(IngestTest, AllStreamsTogetherAreBounded) {
  options_.total_buffer_bytes = 100;
  Start();
  Client a(*ingest_, NewSession("a"));
  Client b(*ingest_, NewSession("b"));
  records_.Hold();
  EXPECT_TRUE(a.Send(1, 1, 90));
  records_.AwaitTransactions(1);
  EXPECT_FALSE(b.Send(1, 1, 20));
  records_.LetGo();
  b.Await("room again");
  EXPECT_TRUE(b.Send(2, 2, 20));
}

TEST_F(IngestTest, WhatAFailedStreamHadBufferedIsFreed) {
  options_.total_buffer_bytes = 100;
  Start();
  Client failing(*ingest_, NewSession("failing"));
  Client other(*ingest_, NewSession("other"));
  records_.Hold();
  records_.FailNext(absl::InternalError("a bug"));
  failing.Send(1, 1, 60);
  records_.AwaitTransactions(1);
  EXPECT_FALSE(failing.Send(2, 2, 60));
  EXPECT_FALSE(other.Send(1, 1, 10));
  records_.LetGo();
  failing.Await("INTERNAL");
  other.Await("room again");
  // Becomes true only if the 60 bytes that the failed stream had still buffered are freed.
  for (std::int64_t next = 2; !other.Send(next, next, 90); ++next) other.Await(fmt::format("stored {}", next));
}

TEST_F(IngestTest, NoEventsAfterCloseButTheItemsAreStored) {
  Start();
  Client client(*ingest_, NewSession("s"));
  records_.Hold();
  client.Send(1, 2);
  records_.AwaitTransactions(1);
  client.Send(3, 4);
  client.Close();
  client.Close();  // no-op
  records_.LetGo();
  Client witness(*ingest_, NewSession("witness"));
  witness.Send(1, 1);
  witness.Await("stored 1");
  EXPECT_THAT(client.events(), IsEmpty());
  EXPECT_EQ(Acknowledged("s"), 4);
}

TEST_F(IngestTest, DrainingTellsEachStreamOnceWhenItsItemsAreStored) {
  Start();
  Client idle(*ingest_, NewSession("idle"));
  Client busy(*ingest_, NewSession("busy"));
  records_.Hold();
  busy.Send(1, 2);
  records_.AwaitTransactions(1);
  busy.Send(3, 4);
  ingest_->Drain();
  records_.LetGo();
  EXPECT_THAT(idle.AwaitEvents(1), ElementsAre("drained"));
  EXPECT_THAT(busy.AwaitEvents(3), ElementsAre("stored 2", "stored 4", "drained"));
  Client late(*ingest_, NewSession("late"));
  EXPECT_THAT(late.AwaitEvents(1), ElementsAre("drained"));
  busy.Send(5, 5);  // a batch that was on its way
  busy.Await("stored 5");
  ingest_->Drain();
  late.Send(1, 1);
  late.Await("stored 1");
  for (Client* client : {&idle, &busy, &late}) {
    const std::vector<std::string> events = client->events();
    EXPECT_EQ(std::count(events.begin(), events.end(), "drained"), 1);
  }
}

TEST_F(IngestTest, TheDestructorStoresWhatWasOffered) {
  Start();
  {
    Client client(*ingest_, NewSession("s"));
    for (std::int64_t i = 0; i < 20; ++i) client.Send(1 + i, 1 + i);
  }
  ingest_.reset();
  EXPECT_EQ(Acknowledged("s"), 20);
}

TEST_F(IngestTest, CountsOpenStreams) {
  Start();
  {
    Client a(*ingest_, NewSession("a"));
    Client b(*ingest_, NewSession("b"));
    EXPECT_EQ(metrics_->streams_open(), 2);
    a.Close();
    EXPECT_EQ(metrics_->streams_open(), 1);
  }
  EXPECT_EQ(metrics_->streams_open(), 0);
}

// Whatever the sizes and the interleaving: everything is stored, and acknowledgements only grow.
TEST_F(IngestTest, ManyStreamsAndWritersStoreEverythingInOrder) {
  options_.writers = 3;
  options_.stream_buffer_bytes = 300;
  options_.total_buffer_bytes = 1000;
  options_.transaction_bytes = 200;
  Start();
  static constexpr int kStreams = 8;
  static constexpr std::int64_t kRecords = 200;
  std::vector<std::thread> threads;
  for (int i = 0; i < kStreams; ++i) NewSession(fmt::format("s{}", i));
  for (int i = 0; i < kStreams; ++i) {
    threads.emplace_back([this, i] {
      Client client(*ingest_, fmt::format("s{}", i));
      std::minstd_rand random(static_cast<unsigned>(i + 1));
      std::size_t rooms = 0;
      for (std::int64_t next = 1; next <= kRecords;) {
        const std::int64_t last = std::min<std::int64_t>(kRecords, next + static_cast<std::int64_t>(random() % 10));
        if (!client.Send(next, last, 1 + random() % 150)) {
          ++rooms;
          // Each false is followed by one RoomAgain.
          while (true) {
            const std::vector<std::string> events = client.events();
            if (static_cast<std::size_t>(std::count(events.begin(), events.end(), "room again")) >= rooms) break;
            std::this_thread::yield();
          }
        }
        next = last + 1;
      }
      client.Await(fmt::format("stored {}", kRecords));
      std::int64_t acknowledged = 0;
      for (const std::string& event : client.events()) {
        if (!event.starts_with("stored ")) continue;
        const std::int64_t sequence = std::stoll(event.substr(7));
        EXPECT_GE(sequence, acknowledged);
        acknowledged = sequence;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(stores_.database.CountRecords(), kStreams * kRecords);
}

}  // namespace
}  // namespace enfilade::server

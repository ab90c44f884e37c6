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

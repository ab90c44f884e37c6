// SPDX-License-Identifier: Apache-2.0
// Random use of a spool against a model in memory, with restarts; and files that lost their end or some bytes.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "client/sdk/spool/spool.h"
#include "io/file.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/spool/spool_samples.h"

namespace enfilade::client {
namespace {

using testing::ImageItem;
using testing::NumberedScan;
using testing::SampleSession;

// What a session must hold.
struct ModelSession {
  std::map<std::int64_t, sensor::RecordPayload> pending;
  std::int64_t last = 0;
  std::int64_t acknowledged = 0;
  std::int64_t quarantined = 0;
  bool finished = false;
};

class SpoolModel : public ::testing::TestWithParam<std::uint32_t> {
 protected:
  static constexpr std::int64_t kMaxBytes = 40'000;

  void Reopen() {
    spool_.reset();
    SpoolOptions options;
    options.max_bytes = kMaxBytes;
    auto spool = Spool::Open(path_, options);
    ASSERT_OK(spool);
    spool_ = *std::move(spool);
  }
  std::uint32_t Draw(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }

  void Append(const std::string& id) {
    ModelSession& session = model_[id];
    std::vector<SpoolItem> items;
    for (std::uint32_t i = 0; i <= Draw(4); ++i) {
      items.push_back(Draw(4) == 0 ? ImageItem("picture " + std::to_string(Draw(5)))
                                   : SpoolItem{NumberedScan(static_cast<int>(++number_), 20), {}});
    }
    const auto appended = spool_->Append(SessionId(id), items);
    if (session.finished) {
      EXPECT_CODE(appended, absl::StatusCode::kFailedPrecondition);
      return;
    }
    if (!appended.ok()) {
      EXPECT_CODE(appended, absl::StatusCode::kResourceExhausted);
      EXPECT_GT(spool_->usage().bytes + 4000, kMaxBytes) << "refused although there was room";
      return;
    }
    for (const SpoolItem& item : items) session.pending[++session.last] = item.payload;
    EXPECT_EQ(*appended, session.last);
  }
  void Acknowledge(const std::string& id) {
    ModelSession& session = model_[id];
    const std::int64_t sequence = static_cast<std::int64_t>(Draw(static_cast<std::uint32_t>(session.last) + 3));
    ASSERT_OK(spool_->Acknowledge(SessionId(id), sequence));
    session.acknowledged = std::max(session.acknowledged, std::min(sequence, session.last));
    session.pending.erase(session.pending.begin(), session.pending.upper_bound(session.acknowledged));
  }
  void Quarantine(const std::string& id) {
    ModelSession& session = model_[id];
    const std::int64_t sequence = 1 + static_cast<std::int64_t>(Draw(static_cast<std::uint32_t>(session.last) + 2));
    const absl::Status status = spool_->Quarantine(SessionId(id), sequence, "refused");
    const auto found = session.pending.find(sequence);
    if (found == session.pending.end()) {
      EXPECT_CODE(status, absl::StatusCode::kNotFound) << sequence;
    } else if (std::holds_alternative<sensor::Withheld>(found->second)) {
      EXPECT_CODE(status, absl::StatusCode::kFailedPrecondition);
    } else {
      EXPECT_OK(status);
      found->second = sensor::Withheld{"refused"};
      ++session.quarantined;
    }
  }
  void Remove(const std::string& id) {
    ASSERT_OK(spool_->RemoveSession(SessionId(id)));
    ASSERT_OK(spool_->CreateSession(SampleSession(id)));
    model_[id] = {};
  }

  void CompareWithModel() {
    std::int64_t records = 0;
    std::int64_t quarantined = 0;
    for (const auto& [id, session] : model_) {
      const auto found = spool_->FindSession(SessionId(id));
      ASSERT_TRUE(found.has_value());
      EXPECT_EQ(found->last_sequence, session.last);
      EXPECT_EQ(found->acknowledged_sequence, session.acknowledged);
      EXPECT_EQ(found->finished, session.finished);
      ASSERT_OK_AND_ASSIGN(const auto batch, spool_->ReadBatch(SessionId(id), session.acknowledged, 1 << 20, 1 << 30));
      ASSERT_EQ(batch.size(), session.pending.size()) << id;
      for (const sensor::Record& record : batch) {
        EXPECT_EQ(record.payload, session.pending.at(record.sequence)) << id << ' ' << record.sequence;
        const sensor::BlobRef* const blob = sensor::FindBlob(record);
        if (blob != nullptr) {
          EXPECT_OK(spool_->ReadBlob(*blob));
        }
      }
      ASSERT_OK_AND_ASSIGN(const auto kept, spool_->ListQuarantined(SessionId(id)));
      EXPECT_EQ(kept.size(), static_cast<std::size_t>(session.quarantined));
      records += static_cast<std::int64_t>(session.pending.size());
      quarantined += session.quarantined;
    }
    EXPECT_EQ(spool_->usage().records, records);
    EXPECT_EQ(spool_->usage().quarantined, quarantined);
  }

  testing::TemporaryDirectory directory_;
  const std::string path_ = (directory_.path() / "robot.spool").string();
  std::unique_ptr<Spool> spool_;
  std::map<std::string, ModelSession> model_;
  std::mt19937 random_{GetParam()};
  std::int64_t number_ = 0;
};

TEST_P(SpoolModel, DoesWhatTheModelDoesAndCountsItsBytesAlikeAfterARestart) {
  ASSERT_NO_FATAL_FAILURE(Reopen());
  for (const std::string id : {"a", "b", "c"}) {
    ASSERT_OK(spool_->CreateSession(SampleSession(id)));
    model_[id] = {};
  }
  for (int step = 0; step < 150; ++step) {
    const std::string id(1, static_cast<char>('a' + Draw(3)));
    const std::uint32_t what = Draw(20);
    if (what < 12) {
      Append(id);
    } else if (what < 15) {
      Acknowledge(id);
    } else if (what < 18) {
      Quarantine(id);
    } else if (what == 18 && Draw(4) == 0) {
      ASSERT_OK(spool_->MarkFinished(SessionId(id)));
      model_[id].finished = true;
    } else if (what == 19 && Draw(4) == 0) {
      Remove(id);
    }
    ASSERT_FALSE(HasFatalFailure()) << step;
    if (step % 30 != 29) continue;
    const SpoolUsage before = spool_->usage();
    ASSERT_NO_FATAL_FAILURE(Reopen());
    EXPECT_EQ(spool_->usage().bytes, before.bytes) << "counted otherwise than loaded";
    ASSERT_NO_FATAL_FAILURE(CompareWithModel());
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SpoolModel, ::testing::Range(1U, 9U));

class BrokenSpool : public ::testing::Test {
 protected:
  void SetUp() override {
    {
      ASSERT_OK_AND_ASSIGN(const auto spool, Spool::Open(path_));
      ASSERT_OK(spool->CreateSession(SampleSession("a")));
      for (int i = 1; i <= 120; ++i) ASSERT_OK(spool->Append(SessionId("a"), NumberedScan(i)));
    }
    ASSERT_OK_AND_ASSIGN(bytes_, io::ReadFile(path_));
    ASSERT_GT(bytes_.size(), 40'000U);
  }
  // Opens a spool of these bytes and reads all of it. Whatever it is, it is said, and every record that comes is one
  // that was appended, or withheld.
  void OpenAndRead(const std::string& bytes, const std::string& what) {
    const std::string path = (directory_.path() / "broken.spool").string();
    for (const char* suffix : {"-wal", "-shm"}) std::filesystem::remove(path + suffix);
    ASSERT_OK(io::WriteFile(path, bytes));
    const auto spool = Spool::Open(path);
    if (!spool.ok()) {
      EXPECT_FALSE(spool.status().message().empty()) << what;
      ++refused_;
      return;
    }
    const auto batch = (*spool)->ReadBatch(SessionId("a"), 0, 1000, 1 << 30);
    if (!batch.ok()) return;
    for (const sensor::Record& record : *batch) {
      if (std::holds_alternative<sensor::Withheld>(record.payload)) continue;
      EXPECT_EQ(record, (sensor::Record{record.sequence, NumberedScan(static_cast<int>(record.sequence))})) << what;
    }
  }

  testing::TemporaryDirectory directory_;
  const std::string path_ = (directory_.path() / "robot.spool").string();
  std::string bytes_;
  int refused_ = 0;
};

TEST_F(BrokenSpool, AFileThatLostItsEndIsNeverReadAsWhole) {
  for (std::size_t size = 0; size < bytes_.size(); size += 1777) {
    OpenAndRead(bytes_.substr(0, size), "cut at " + std::to_string(size));
  }
  EXPECT_GT(refused_, 5);
}

TEST_F(BrokenSpool, NoDamagedRecordPassesForAGoodOne) {
  std::mt19937 random(7);
  for (int i = 0; i < 60; ++i) {
    std::string damaged = bytes_;
    const std::size_t at = random() % damaged.size();
    for (std::size_t k = at; k < std::min(damaged.size(), at + 1 + random() % 50); ++k) {
      damaged[k] = static_cast<char>(random());
    }
    OpenAndRead(damaged, "damaged at " + std::to_string(at));
  }
}

}  // namespace
}  // namespace enfilade::client

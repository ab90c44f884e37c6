// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "client/sdk/uplink/uplink.h"
#include "proto/convert/record.h"
#include "tests/support/fake_server/fake_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/spool/spool_samples.h"

namespace enfilade::testing {

inline const SessionId kRun("run-1");
constexpr const char* kRunName = "sites/campus/sessions/run-1";

// A spool with a session, and a server to bring it to.
class UplinkTest : public ::testing::Test {
 protected:
  UplinkTest() {
    spool_ = *client::Spool::Open((directory_.path() / "robot.spool").string());
    EXPECT_OK(spool_->CreateSession(SampleSession()));
    options_.min_backoff_s = 0.001;
    options_.max_backoff_s = 0.02;
    options_.stream.max_batch_records = 20;
  }

  void Serve(FakeServer::Behaviour behaviour = {}) {
    server_ = std::make_unique<FakeServer>("unix:" + (directory_.path() / "server").string(), std::move(behaviour));
  }
  // Appends items, each one unlike the others; every `image_every`-th is an image of `image_bytes`.
  void Record(int items, int image_every = 0, std::size_t image_bytes = 1000) {
    std::vector<client::SpoolItem> batch;
    for (int i = 0; i < items; ++i) {
      ++recorded_;
      if (image_every > 0 && recorded_ % image_every == 0) {
        batch.push_back(ImageItem(std::to_string(recorded_) + std::string(image_bytes, 'p')));
      } else {
        batch.push_back({NumberedScan(recorded_, 30), {}});
      }
    }
    ASSERT_OK(spool_->Append(kRun, batch));
  }
  void RecordAll(int items, int image_every = 0, std::size_t image_bytes = 1000) {
    Record(items, image_every, image_bytes);
    ASSERT_OK(spool_->MarkFinished(kRun));
  }
  // Brings everything over `address` and gives the outcome.
  absl::Status Bring(const std::string& address) {
    client::Uplink uplink(client::Connection(address, std::chrono::seconds(20)), *spool_, kRun, options_);
    uplink.Start();
    const auto result = uplink.WaitFor(std::chrono::minutes(2));
    progress_ = uplink.progress();
    return result.value_or(absl::DeadlineExceededError("the uplink has not come to an end"));
  }
  absl::Status Bring() { return Bring(server_->address()); }

  // The session is finished on the server and holds every record once, as it was recorded.
  void ExpectAllStored(const std::set<std::int64_t>& withheld = {}) {
    const auto sessions = server_->sessions();
    ASSERT_EQ(sessions.size(), 1U);
    const FakeServer::Session& session = sessions.begin()->second;
    EXPECT_TRUE(session.finished);
    EXPECT_EQ(session.conflicts, 0);
    ASSERT_EQ(session.records.size(), static_cast<std::size_t>(recorded_));
    for (const auto& [sequence, stored] : session.records) {
      if (withheld.contains(sequence)) {
        EXPECT_TRUE(stored.has_withheld());
      } else if (stored.has_laser_scan()) {
        ASSERT_EQ(*convert::FromProto(stored),
                  (enfilade::sensor::Record{sequence, NumberedScan(static_cast<int>(sequence), 30)}));
      } else {
        ASSERT_TRUE(stored.has_image());
        const std::string content = server_->blobs()[stored.image().content().sha256()];
        ASSERT_EQ(content.substr(0, content.find('p')), std::to_string(sequence));
      }
    }
    EXPECT_TRUE(spool_->FindSession(kRun)->closed);
    EXPECT_EQ(spool_->usage().records, 0);
  }

  TemporaryDirectory directory_;
  std::unique_ptr<client::Spool> spool_;
  std::unique_ptr<FakeServer> server_;
  client::UplinkOptions options_;
  client::UplinkProgress progress_;
  int recorded_ = 0;
};

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/metrics.h"

#include <gmock/gmock.h>

#include <string>

#include "fmt/format.h"
#include "tests/support/scrape.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using enfilade::testing::FreePort;
using enfilade::testing::Scrape;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class MetricsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    port_ = FreePort();
    auto metrics = Metrics::Create(fmt::format("127.0.0.1:{}", port_));
    ASSERT_OK(metrics);
    metrics_ = *std::move(metrics);
  }

  int port_ = 0;
  std::unique_ptr<Metrics> metrics_;
};

TEST_F(MetricsTest, ServesCallsByNameAndCode) {
  metrics_->CountCall("GetMap", absl::StatusCode::kOk, std::chrono::milliseconds(3));
  metrics_->CountCall("GetMap", absl::StatusCode::kOk, std::chrono::milliseconds(30));
  metrics_->CountCall("GetMap", absl::StatusCode::kNotFound, std::chrono::milliseconds(1));
  metrics_->CountCall("ListMaps", absl::StatusCode::kOk, std::chrono::milliseconds(1));
  const std::string page = Scrape(port_);
  EXPECT_THAT(page, AllOf(HasSubstr(R"(enfilade_calls_total{code="OK",rpc="GetMap"} 2)"),
                          HasSubstr(R"(enfilade_calls_total{code="NOT_FOUND",rpc="GetMap"} 1)"),
                          HasSubstr(R"(enfilade_calls_total{code="OK",rpc="ListMaps"} 1)")));
  // One histogram per RPC over all codes: 1 ms and 3 ms are at most 5 ms.
  EXPECT_THAT(page, AllOf(HasSubstr(R"(enfilade_call_seconds_bucket{rpc="GetMap",le="0.005"} 2)"),
                          HasSubstr(R"(enfilade_call_seconds_count{rpc="GetMap"} 3)")));
}

TEST_F(MetricsTest, ServesCountersAndGauges) {
  metrics_->CountRecordsStored(7, 2);
  metrics_->CountBatchRefused();
  metrics_->AddIngestBuffered(100);
  metrics_->AddIngestBuffered(-40);
  metrics_->CountScansMapped(5, 1);
  metrics_->SetMappingBacklog({3, 1.5, 2, 0.5});
  metrics_->CountIdleSessionsClosed(2, 1);
  metrics_->CountRowsDeleted("map_revisions", 3);
  metrics_->CountRowsDeleted("map_revisions", 4);
  metrics_->SetReady(true);
  metrics_->SetDatabaseConnections(4, 3, 2);
  EXPECT_THAT(
      Scrape(port_),
      AllOf(HasSubstr("enfilade_records_stored_total 7\n"), HasSubstr("enfilade_records_duplicate_total 2\n"),
            HasSubstr("enfilade_batches_refused_total 1\n"), HasSubstr("enfilade_ingest_buffered_bytes 60\n"),
            HasSubstr("enfilade_scans_mapped_total{used=\"true\"} 5\n"),
            HasSubstr("enfilade_idle_sessions_closed_total{as=\"finished\"} 2\n"),
            HasSubstr("enfilade_idle_sessions_closed_total{as=\"failed\"} 1\n"),
            HasSubstr("enfilade_rows_deleted_total{of=\"map_revisions\"} 7\n"),
            HasSubstr("enfilade_mapping_waiting_sessions 3\n"), HasSubstr("enfilade_mapping_lag_seconds 1.5\n"),
            HasSubstr("enfilade_sessions_without_map 2\n"), HasSubstr("enfilade_door_lag_seconds 0.5\n"),
            HasSubstr("enfilade_scans_mapped_total{used=\"false\"} 1\n"), HasSubstr("enfilade_ready 1\n"),
            HasSubstr("enfilade_database_connections_open 4\n"), HasSubstr("enfilade_database_connections_busy 3\n"),
            HasSubstr("enfilade_database_connections_waiting 2\n")));
  metrics_->SetReady(false);
  EXPECT_THAT(Scrape(port_), AllOf(HasSubstr("enfilade_ready 0\n"), Not(HasSubstr("enfilade_ready 1\n"))));
}

TEST_F(MetricsTest, AnAddressInUseIsAnErrorThatNamesIt) {
  const std::string address = fmt::format("127.0.0.1:{}", port_);
  EXPECT_STATUS(Metrics::Create(address), absl::StatusCode::kUnavailable,
                AllOf(HasSubstr(address), HasSubstr("metrics.address")));
}

TEST(Metrics, WithoutAnAddressTheyAreOnlyCollected) {
  ASSERT_OK_AND_ASSIGN(const auto metrics, Metrics::Create(""));
  metrics->AddStreamsOpen(3);
  metrics->AddStreamsOpen(-1);
  metrics->AddSessionsMapping(1);
  EXPECT_EQ(metrics->streams_open(), 2);
  EXPECT_EQ(metrics->sessions_mapping(), 1);
}

}  // namespace
}  // namespace enfilade::server

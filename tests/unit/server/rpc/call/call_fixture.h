// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <sstream>
#include <string>

#include "server/rpc/call/call.h"
#include "spdlog/sinks/ostream_sink.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {

// Calls without gRPC and without a database: an executor of one thread, metrics that nobody reads, and a log in memory.
class CallFixture : public ::testing::Test {
 protected:
  explicit CallFixture(std::size_t max_queued = 100) : executor_(1, max_queued) {
    auto metrics = Metrics::Create("");
    EXPECT_OK(metrics);
    metrics_ = *std::move(metrics);
    environment_ = std::make_unique<CallEnvironment>(CallEnvironment{
        .executor = executor_, .metrics = *metrics_, .logger = logger_, .default_timeout = std::chrono::seconds(30)});
    logger_->set_level(spdlog::level::trace);
    logger_->set_pattern("%l: %v");
  }

  std::string Log() {
    logger_->flush();
    return log_.str();
  }

  std::ostringstream log_;
  const std::shared_ptr<spdlog::logger> logger_ =
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log_));
  std::unique_ptr<Metrics> metrics_;
  Executor executor_;
  std::unique_ptr<CallEnvironment> environment_;
};

}  // namespace enfilade::server

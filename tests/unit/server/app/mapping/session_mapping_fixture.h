// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <utility>

#include "server/app/mapping/session_mapping.h"
#include "tests/unit/server/app/mapping/mapping_fixture.h"

namespace enfilade::server {

// Maps sessions as a worker does, turn by turn.
class SessionMappingFixture : public MappingFixture {
 protected:
  static constexpr auto kSessionLeaseTime = std::chrono::seconds(10);
  using Progress = SessionMapping::Progress;

  storage::LeasedSession Acquire() {
    auto leased = stores_.mappings.Acquire(Soon(), "worker", kSessionLeaseTime);
    EXPECT_OK(leased);
    EXPECT_TRUE(leased->has_value());
    return **leased;
  }
  std::unique_ptr<SessionMapping> Load(const storage::LeasedSession& leased) {
    auto mapping = SessionMapping::Load(mapping_stores(), options_, leased.session);
    EXPECT_OK(mapping);
    return mapping.ok() ? *std::move(mapping) : nullptr;
  }
  static Progress MapOn(SessionMapping& mapping, const storage::SessionLease& lease) {
    while (true) {
      const auto progress = mapping.Step(lease);
      EXPECT_OK(progress);
      if (!progress.ok() || *progress != Progress::kWorked) return progress.value_or(Progress::kWaiting);
    }
  }
  // Maps a session to its end, as a worker does.
  void MapAll(const SessionId& session) {
    const storage::LeasedSession leased = Acquire();
    ASSERT_EQ(leased.session.id, session);
    const auto mapping = Load(leased);
    EXPECT_EQ(MapOn(*mapping, leased.lease), Progress::kEnded);
    EXPECT_OK(stores_.mappings.Release(Soon(), leased.lease, 0));
  }

  SessionMappingOptions options_;
};

}  // namespace enfilade::server

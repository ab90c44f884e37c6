// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/sha256.h"
#include "storage/sessions/mapping_store.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {

inline Eigen::Matrix3d MatrixOf(double scale) {
  Eigen::Matrix3d matrix;
  matrix << 1.0 / 3, 0.1, 0.2, 0.1, 1.0 / 7, 0.3, 0.2, 0.3, 1e-17;
  return scale * matrix;
}

inline slam::SlamNode NodeOf(std::int64_t id, double x) {
  return {id, 10 * id + 1, (id + 1) * kNsPerSecond, {x, 1.0 / 3, -0.1}, MatrixOf(static_cast<double>(id)), 0};
}

// The delta of a mapper's first step: one submap, two nodes, a closure, three scans.
inline slam::SlamDelta FirstDelta() {
  slam::SlamDelta delta;
  delta.submaps = {{0, 1, {0.0, -0.0, 0.5}, false, ""}};
  delta.nodes = {NodeOf(0, 0.0), NodeOf(1, 1.5)};
  delta.loop_closures = {
      {0, 0, 1, {0.1, 0.2, 0.3}, MatrixOf(2), slam::LoopClosureState::kRejected, 0.25, 7.5, "too few \"inliers\""}};
  delta.trajectory = {{1, kNsPerSecond, 0, {0, 0, 0}},
                      {5, kNsPerSecond * 3 / 2, 0, {0.75, 0, 0}},
                      {11, 2 * kNsPerSecond, 1, {0, 0, 0}}};
  return delta;
}

class MappingStoreTest : public StoreContractTest {
 protected:
  storage::LeasedSession AcquireOne(const std::string& owner = "worker",
                                    std::chrono::milliseconds ttl = std::chrono::seconds(60)) {
    const auto leased = mapping_.Acquire(Soon(), owner, ttl);
    EXPECT_OK(leased);
    EXPECT_TRUE(leased->has_value());
    return **leased;
  }
  bool FindsWork() {
    const auto leased = mapping_.Acquire(Soon(), "another", std::chrono::seconds(60));
    EXPECT_OK(leased);
    return leased->has_value();
  }
  SessionId SessionWithRecords(const std::string& id, std::int64_t count) {
    const SessionId session = NewSession(id);
    EXPECT_OK(Append(session, ScanRecords(1, count)));
    return session;
  }
  absl::Status CommitStep(const storage::SessionLease& lease, const slam::SlamDelta& delta,
                          std::int64_t mapped_sequence) {
    return mapping_.Commit(Soon(), lease, StepOf(delta, "state", mapped_sequence)).status();
  }
  slam::SlamMap LoadMap(const SessionId& session) {
    const auto stored = mapping_.Load(Soon(), site_, session);
    EXPECT_OK(stored);
    EXPECT_TRUE(stored->has_value());
    return (*stored)->map;
  }
  storage::NewRevision RevisionOf(const SessionId& session, const TestBlob& tile) {
    storage::NewRevision revision;
    revision.session = session;
    revision.geometry = {0.05, {-1, -2, 0}, 10, 10};
    revision.content_sha256 = Sha256("content of " + tile.data());
    revision.tiles = {{{0, 0}, tile.sha256()}};
    return revision;
  }
};

inline void ExpectEqual(const slam::SlamMap& map, const slam::SlamMap& expected) {
  EXPECT_EQ(map.nodes, expected.nodes);
  EXPECT_EQ(map.submaps, expected.submaps);
  EXPECT_EQ(map.loop_closures, expected.loop_closures);
  EXPECT_EQ(map.trajectory, expected.trajectory);
}

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "storage/call_context.h"
#include "tests/contract/storage/store_values.h"
#include "tests/contract/storage/suite/backend.h"

namespace enfilade::testing {

// The stores of a backend, with a site "campus", a robot "r1" and a map "hall" in it.
class ContractStores {
 protected:
  explicit ContractStores(std::unique_ptr<Backend> backend);

  // Time enough for any one call.
  static storage::CallContext Soon() { return storage::CallContext::WithTimeout(std::chrono::seconds(60)); }
  // A new session of r1 into "hall"; without `mapped` only recorded.
  SessionId NewSession(const std::string& id, bool mapped = true);
  absl::StatusOr<storage::AppendResult> Append(const SessionId& session, const std::vector<sensor::Record>& records,
                                               const std::vector<storage::BlobView>& blobs = {});

  const SiteId site_{"campus"};
  const RobotId robot_{"r1"};
  const MapId map_{"hall"};
  const std::unique_ptr<Backend> backend_;
  const storage::MapStore& maps_ = backend_->maps();
  const storage::RevisionStore& revisions_ = backend_->revisions();
  const storage::SessionStore& sessions_ = backend_->sessions();
  const storage::RecordStore& records_ = backend_->records();
  const storage::BlobStore& blobs_ = backend_->blobs();
  const storage::MappingStore& mapping_ = backend_->mappings();
  const storage::LinkPointStore& link_points_ = backend_->link_points();
  const storage::GraphStore& graph_ = backend_->graphs();
  const storage::SiteLeaseStore& leases_ = backend_->site_leases();
  const storage::RobotPoseStore& robot_poses_ = backend_->robot_poses();
  const storage::RearrangementStore& rearrangements_ = backend_->rearrangements();
};

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/suite/contract_stores.h"

#include <utility>

#include "tests/support/status_assertions.h"

namespace enfilade::testing {

ContractStores::ContractStores(std::unique_ptr<Backend> backend) : backend_(std::move(backend)) {
  backend_->AddSite(site_);
  backend_->AddRobot(site_, robot_);
  EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, map_, "Hall"), ""));
}

SessionId ContractStores::NewSession(const std::string& id, bool mapped) {
  const SessionId session(id);
  EXPECT_OK(sessions_.Create(
      Soon(), MakeSession(site_, session, robot_, mapped ? std::optional<MapId>(map_) : std::nullopt), ""));
  return session;
}

absl::StatusOr<storage::AppendResult> ContractStores::Append(const SessionId& session,
                                                             const std::vector<sensor::Record>& records,
                                                             const std::vector<storage::BlobView>& blobs) {
  return records_.Append(Soon(), {site_, session, records, blobs});
}

}  // namespace enfilade::testing

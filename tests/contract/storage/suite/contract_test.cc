// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {

StoreContractTest::StoreContractTest() {
  backend_->AddSite(site_);
  backend_->AddRobot(site_, robot_);
  EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, map_, "Hall"), ""));
}

SessionId StoreContractTest::NewSession(const std::string& id, bool mapped) {
  const SessionId session(id);
  EXPECT_OK(sessions_.Create(
      Soon(), MakeSession(site_, session, robot_, mapped ? std::optional<MapId>(map_) : std::nullopt), ""));
  return session;
}

absl::StatusOr<storage::AppendResult> StoreContractTest::Append(const SessionId& session,
                                                                const std::vector<sensor::Record>& records,
                                                                const std::vector<storage::BlobView>& blobs) {
  return records_.Append(Soon(), {site_, session, records, blobs});
}

}  // namespace enfilade::testing

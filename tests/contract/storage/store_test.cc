// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {

StoreTest::StoreTest() {
  EXPECT_OK(sites_.Create(Soon(), MakeSite(site_, "Campus"), ""));
  EXPECT_OK(robots_.Create(Soon(), MakeRobot(site_, robot_, "Robot 1"), ""));
  EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, map_, "Hall"), ""));
}

SessionId StoreTest::NewSession(const std::string& id, bool mapped) {
  const SessionId session(id);
  EXPECT_OK(sessions_.Create(
      Soon(), MakeSession(site_, session, robot_, mapped ? std::optional<MapId>(map_) : std::nullopt), ""));
  return session;
}

absl::StatusOr<storage::AppendResult> StoreTest::Append(const SessionId& session,
                                                        const std::vector<sensor::Record>& records,
                                                        const std::vector<storage::BlobView>& blobs) {
  return records_.Append(Soon(), {site_, session, records, blobs});
}

void StoreTest::DeleteSite(const SiteId& site) {
  using Progress = storage::SiteDeletion::Progress;
  const storage::SiteDeletion deletion(*pool_);
  ASSERT_OK(sites_.Delete(Soon(), site, 0, true));
  for (Progress progress = Progress::kMore; progress == Progress::kMore;) {
    ASSERT_OK_AND_ASSIGN(const auto portion, deletion.DeletePortion(Soon(), site, 1000));
    progress = portion.progress;
  }
}

}  // namespace enfilade::testing

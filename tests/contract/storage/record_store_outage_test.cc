// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <thread>

#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

class RecordStoreOutageTest : public StoreTest {};

TEST_F(RecordStoreOutageTest, AKilledConnectionStoresAllOrNothingAndTheBatchCanBeSentAgain) {
  const SessionId session = NewSession("s1");
  std::atomic<bool> done = false;
  std::thread killer([&] {
    while (!done) {
      database_.Sql(
          "SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
          " WHERE datname = current_database() AND application_name = 'enfilade'");
      std::this_thread::sleep_for(std::chrono::milliseconds(15));
    }
  });
  int unavailable = 0;
  for (std::int64_t first = 1; first <= 200; first += 10) {
    const auto batch = ScanRecords(first, first + 9);
    absl::Status status;
    do {
      const auto result = Append(session, batch);
      status = result.status();
      if (result.ok()) {
        EXPECT_EQ(result->acknowledged_sequence, first + 9);
      }
      if (!status.ok()) {
        EXPECT_CODE(status, absl::StatusCode::kUnavailable);
        ++unavailable;
      }
    } while (!status.ok() && unavailable < 10'000);
  }
  done = true;
  killer.join();
  // Connections that were killed last may still be found dead.
  absl::StatusOr<storage::Session> found = sessions_.Get(Soon(), site_, session);
  for (int i = 0; i < 100 && absl::IsUnavailable(found.status()); ++i) found = sessions_.Get(Soon(), site_, session);
  ASSERT_OK_AND_ASSIGN(const storage::Session stored, std::move(found));
  ASSERT_OK_AND_ASSIGN(const auto records, records_.Read(Soon(), site_, session, 1, 1 << 30));
  EXPECT_EQ(records, ScanRecords(1, 200));
  EXPECT_EQ(stored.record_counts.laser_scans, 200);
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/server_memory.h"

#include <libpq-fe.h>

#include <algorithm>
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>

#include "tests/bench/support/load_generator.h"

namespace enfilade::bench {
namespace {

constexpr int kRobots = 50;
constexpr int kScansPerRobot = 20'000;
constexpr int kBatchRecords = 200;
constexpr auto kLocked = std::chrono::seconds(15);  // less than the server waits for one write
constexpr auto kSampleEvery = std::chrono::milliseconds(100);

double MiB(std::int64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

}  // namespace

nlohmann::json MeasureServerMemory(BenchSystem& system) {
  const pid_t server = system.server().process().pid();
  const std::vector<LoadBatch> batches = ToBatches(RandomScans(kScansPerRobot, 7), kBatchRecords);
  std::int64_t offered = 0;
  for (const LoadBatch& batch : batches) offered += batch.bytes * kRobots;
  const std::int64_t before = testing::ResidentBytes(server);
  const std::unique_ptr<PGconn, void (*)(PGconn*)> blocker(PQconnectdb(system.database_url().c_str()), PQfinish);
  PQclear(PQexec(blocker.get(), "BEGIN"));
  PQclear(PQexec(blocker.get(), "LOCK TABLE enfilade.session_records IN EXCLUSIVE MODE"));
  if (PQtransactionStatus(blocker.get()) != PQTRANS_INTRANS) throw std::runtime_error(PQerrorMessage(blocker.get()));

  const LoadGenerator generator(
      {.address = system.server().address(), .sessions = system.CreateSessions(kRobots), .window = 0}, batches);
  std::future<LoadResult> load = std::async(std::launch::async, [&] { return generator.Run(); });
  std::int64_t peak = before;
  std::vector<double> samples;
  const auto sample = [&] {
    const std::int64_t now = testing::ResidentBytes(server);
    peak = std::max(peak, now);
    samples.push_back(MiB(now));
    std::this_thread::sleep_for(kSampleEvery);
  };
  for (const auto end = std::chrono::steady_clock::now() + kLocked; std::chrono::steady_clock::now() < end;) sample();
  const std::int64_t while_locked = peak;
  const double settled = samples[samples.size() * 2 / 3];  // at two thirds of the time
  const double at_end = samples.back();
  PQclear(PQexec(blocker.get(), "ROLLBACK"));
  while (load.wait_for(std::chrono::seconds(0)) != std::future_status::ready) sample();
  const LoadResult result = load.get();
  return {{"robots", kRobots},
          {"offered_mib", MiB(offered)},
          {"rss_before_mib", MiB(before)},
          {"rss_after_two_thirds_of_the_standstill_mib", settled},
          {"rss_at_end_of_the_standstill_mib", at_end},
          {"rss_peak_in_the_standstill_mib", MiB(while_locked)},
          {"rss_peak_mib", MiB(peak)},
          {"records_acknowledged", result.acknowledged},
          {"records_offered", std::int64_t{kRobots} * kScansPerRobot},
          {"error", result.error}};
}

}  // namespace enfilade::bench

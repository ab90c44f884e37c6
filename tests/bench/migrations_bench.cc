// SPDX-License-Identifier: Apache-2.0
// usage: bench_migrations [RECORDS]
// How long each migration keeps writers waiting on a database with that many records, trajectory points, blobs and
// tiles of revisions (default a million of each), forward and back. Prints JSON.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "storage/postgres/driver/transaction.h"
#include "storage/schema.h"
#include "tests/support/command.h"
#include "tests/support/database.h"

namespace enfilade::bench {
namespace {

using Clock = std::chrono::steady_clock;
using storage::postgres::Params;
using storage::postgres::Statement;

constexpr std::string_view kFirst = "mapping";  // from here on there are tables that grow
constexpr int kRecordsOfSession = 1000;

// What every change of the schema still knows.
constexpr Statement kWrites[] = {
    {"recording",
     "INSERT INTO enfilade.session_records (site_id, session_id, sequence, time_ns, kind, payload)"
     " SELECT 'a', 's0', max(sequence) + 1, 0, 1, '\\x00' FROM enfilade.session_records"
     " WHERE site_id = 'a' AND session_id = 's0'"},
    {"mapping",
     "INSERT INTO enfilade.trajectory_points (site_id, session_id, sequence, time_ns, node_id, x, y, yaw)"
     " SELECT 'a', 's0', max(sequence) + 1, 0, 0, 0, 0, 0 FROM enfilade.trajectory_points"
     " WHERE site_id = 'a' AND session_id = 's0'"},
    {"storing a blob",
     "INSERT INTO enfilade.blobs (site_id, sha256, data) VALUES ('a', sha256(gen_random_uuid()::text::bytea), 'x')"},
    {"counting",
     "UPDATE enfilade.sessions SET payload_bytes = payload_bytes + 1"
     " WHERE site_id = 'a' AND session_id = 's0'"},
};

// Writes one row after the other, as the server does, and knows the longest that one of them took.
class Writer {
 public:
  explicit Writer(const testing::TestDatabase& database) {
    auto pool = storage::postgres::Pool::Create({.url = database.url()});
    if (!pool.ok()) throw std::runtime_error(pool.status().ToString());
    pool_ = *std::move(pool);
    thread_ = std::thread([this] { Run(); });
  }
  ~Writer() {
    stop_ = true;
    thread_.join();
  }

  // Since the last call, in milliseconds.
  double TakeLongest() { return longest_ms_.exchange(0.0); }
  int failures() const { return failures_; }

 private:
  void Run() {
    while (!stop_) {
      for (const Statement& write : kWrites) {
        const auto begin = Clock::now();
        const auto context = storage::CallContext::WithTimeout(std::chrono::minutes(30));
        const auto result = storage::postgres::ExecuteAlone(*pool_, context, write, Params());
        if (!result.ok() && failures_++ == 0) std::cerr << result.status().ToString() << '\n';
        const double took = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
        longest_ms_ = std::max(longest_ms_.load(), took);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  std::unique_ptr<storage::postgres::Pool> pool_;
  std::atomic<double> longest_ms_ = 0.0;
  std::atomic<int> failures_ = 0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

void Migrate(const testing::TestDatabase& database, const std::string& command, std::string_view change) {
  const testing::CommandResult result = testing::RunCommand(
      {testing::ProjectFile("deploy/database/migrate"), command, database.url(), std::string(change)});
  if (result.exit_code != 0) throw std::runtime_error(result.output);
}

// Sessions of a thousand records and points each.
void Fill(const testing::TestDatabase& database, std::int64_t records) {
  const std::int64_t sessions = std::max<std::int64_t>(1, records / kRecordsOfSession);
  const auto insert = [&](const std::string& into, const std::string& rest) {
    database.Sql("INSERT INTO enfilade." + into + " " + rest);
    std::cerr << into.substr(0, into.find(' ')) << " filled\n";
  };
  const std::string each_session = fmt::format("FROM generate_series(0, {}) s", sessions - 1);
  const std::string each_record = each_session + fmt::format(", generate_series(1, {}) i", kRecordsOfSession);
  insert("sites (site_id, display_name)", "VALUES ('a', 'A')");
  insert("robots (site_id, robot_id, display_name)", "VALUES ('a', 'r', 'R')");
  insert("maps (site_id, map_id, display_name, environment)", "VALUES ('a', 'm', 'M', 1)");
  insert("sessions (site_id, session_id, robot_id, map_id, laser_scans, acknowledged_sequence, highest_sequence)",
         fmt::format("SELECT 'a', 's' || s, 'r', 'm', {0}, {0}, {0} ", kRecordsOfSession) + each_session);
  insert("slam_submaps (site_id, session_id, submap_id, version, x, y, yaw, finished, content)",
         "SELECT 'a', 's' || s, 0, 1, 0, 0, 0, true, '' " + each_session);
  insert("slam_nodes (site_id, session_id, node_id, sequence, time_ns, x, y, yaw, covariance, submap_id)",
         "SELECT 'a', 's' || s, i, i, i, 0, 0, 0, array_fill(0::float8, '{9}'), 0 " + each_session +
             ", generate_series(0, 99) i");
  insert("session_records (site_id, session_id, sequence, time_ns, kind, payload)",
         "SELECT 'a', 's' || s, i, i, 1, '\\x000102030405060708090a0b0c0d0e0f' " + each_record);
  insert("trajectory_points (site_id, session_id, sequence, time_ns, node_id, x, y, yaw)",
         "SELECT 'a', 's' || s, i, i, i % 100, 0, 0, 0 " + each_record);
  const std::string digest = fmt::format("sha256((s * {} + i)::text::bytea)", kRecordsOfSession);
  insert("blobs (site_id, sha256, data)", "SELECT 'a', " + digest + ", 'x' " + each_record);
  insert("session_record_blobs (site_id, session_id, sequence, sha256)",
         "SELECT 'a', 's' || s, i, " + digest + " " + each_record);
  insert(
      "map_revisions (site_id, map_id, revision, source, session_id, resolution, origin_x, origin_y, origin_yaw, width,"
      " height, raster_header, content_sha256, tile_count, tile_bytes)",
      fmt::format("SELECT 'a', 'm', s + 1, 1, 's' || s, 0.05, 0, 0, 0, 1, 1, '', sha256(s::text::bytea), {0}, {0} ",
                  kRecordsOfSession) +
          each_session);
  insert("map_revision_tiles (site_id, map_id, revision, tile_row, tile_column, sha256)",
         "SELECT 'a', 'm', s + 1, i, 0, " + digest + " " + each_record);
  database.Sql("UPDATE enfilade.maps SET current_revision = 1, state = 3");
  database.Sql("ANALYZE");
}

nlohmann::json Step(const testing::TestDatabase& database, Writer& writer, const std::string& command,
                    std::string_view change) {
  writer.TakeLongest();
  const auto begin = Clock::now();
  Migrate(database, command, change);
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return {{"s", seconds}, {"longest_wait_ms", writer.TakeLongest()}};
}

nlohmann::json Measure(std::int64_t records) {
  const testing::TestDatabase database(testing::TestDatabase::Content::kEmpty);
  Migrate(database, "up", kFirst);
  Fill(database, records);
  Writer writer(database);
  std::this_thread::sleep_for(std::chrono::seconds(10));
  nlohmann::json report = {{"benchmark", "migrations"},
                           {"records", records},
                           {"trajectory_points", records},
                           {"longest_wait_without_migration_ms", writer.TakeLongest()}};
  const auto all = storage::KnownChanges();
  const auto first = std::find(all.begin(), all.end(), kFirst);
  for (auto change = first + 1; change != all.end(); ++change) {
    report["changes"][std::string(*change)]["deploy"] = Step(database, writer, "up", *change);
    std::cerr << *change << ' ' << report["changes"][std::string(*change)].dump() << '\n';
  }
  for (auto change = all.end() - 1; change != first; --change) {
    report["changes"][std::string(*change)]["revert"] = Step(database, writer, "down", *(change - 1));
    std::cerr << *change << ' ' << report["changes"][std::string(*change)].dump() << '\n';
  }
  report["failed_writes"] = writer.failures();
  return report;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  try {
    std::cout << enfilade::bench::Measure(argc > 1 ? std::stoll(argv[1]) : 1'000'000).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_migrations: " << failure.what() << '\n';
    return 1;
  }
}

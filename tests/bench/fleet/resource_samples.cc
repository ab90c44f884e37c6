// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/fleet/resource_samples.h"

#include <libpq-fe.h>

#include <filesystem>
#include <iterator>
#include <stdexcept>

#include "tests/bench/support/processor_time.h"
#include "tests/support/process.h"

namespace enfilade::bench {
namespace {

int OpenFiles(pid_t pid) {
  std::error_code error;
  const std::filesystem::directory_iterator files("/proc/" + std::to_string(pid) + "/fd", error);
  return error ? 0 : static_cast<int>(std::distance(begin(files), end(files)));
}

constexpr char kSample[] =
    "SELECT (SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND pid <> pg_backend_pid()),"
    " pg_database_size(current_database()), coalesce(sum(behind), 0), count(*)"
    " FROM (SELECT s.acknowledged_sequence - coalesce(c.mapped_sequence, 0) AS behind FROM enfilade.sessions s"
    "   LEFT JOIN enfilade.mapping_checkpoints c USING (site_id, session_id)"
    "   WHERE s.delete_time IS NULL AND s.state IN (1, 2)) b WHERE behind > 0";
constexpr char kTableSizes[] =
    "SELECT relname, pg_table_size(relid), pg_indexes_size(relid), n_dead_tup FROM pg_stat_user_tables"
    " WHERE schemaname = 'enfilade' ORDER BY 1";

}  // namespace

void ResourceSampler::Disconnect::operator()(pg_conn* connection) const { PQfinish(connection); }

ResourceSampler::ResourceSampler(pid_t server, pid_t database, const std::string& database_url,
                                 std::chrono::duration<double> every)
    : server_(server),
      database_(database),
      start_(std::chrono::steady_clock::now()),
      connection_(PQconnectdb(database_url.c_str())) {
  if (PQstatus(connection_.get()) != CONNECTION_OK) throw std::runtime_error(PQerrorMessage(connection_.get()));
  worker_ = std::thread([this, every] {
    auto due = start_;
    while (true) {
      samples_.push_back(Take());
      due += std::chrono::duration_cast<std::chrono::steady_clock::duration>(every);
      MutexLock lock(mutex_);
      while (!stop_ && changed_.WaitUntil(mutex_, due)) {
      }
      if (stop_) return;
    }
  });
}

ResourceSampler::~ResourceSampler() { Stop(); }

std::vector<ResourceSample> ResourceSampler::Stop() {
  {
    MutexLock lock(mutex_);
    stop_ = true;
    changed_.NotifyAll();
  }
  if (worker_.joinable()) worker_.join();
  return samples_;
}

ResourceSample ResourceSampler::Take() {
  ResourceSample sample;
  sample.at = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  sample.server_bytes = testing::ResidentBytes(server_);
  sample.server_files = OpenFiles(server_);
  sample.server_cpu_s = ProcessorSeconds(server_);
  sample.database_cpu_s = ProcessorSecondsOfTree(database_);
  const std::vector<std::string> row = Query(kSample).at(0);
  sample.connections = std::stoi(row[0]);
  sample.database_bytes = std::stoll(row[1]);
  sample.backlog_records = std::stoll(row[2]);
  sample.backlog_sessions = std::stoll(row[3]);
  for (const auto& table : Query(kTableSizes)) {
    sample.tables.push_back({table[0], std::stoll(table[1]), std::stoll(table[2]), std::stoll(table[3])});
  }
  return sample;
}

std::vector<std::vector<std::string>> ResourceSampler::Query(const std::string& sql) {
  const std::unique_ptr<PGresult, void (*)(PGresult*)> result(PQexec(connection_.get(), sql.c_str()), PQclear);
  if (PQresultStatus(result.get()) != PGRES_TUPLES_OK) throw std::runtime_error(PQerrorMessage(connection_.get()));
  std::vector<std::vector<std::string>> rows(static_cast<std::size_t>(PQntuples(result.get())));
  for (int i = 0; i < PQntuples(result.get()); ++i) {
    for (int k = 0; k < PQnfields(result.get()); ++k) {
      rows[static_cast<std::size_t>(i)].emplace_back(PQgetvalue(result.get(), i, k));
    }
  }
  return rows;
}

}  // namespace enfilade::bench

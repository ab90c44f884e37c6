// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "nlohmann/json.hpp"

struct pg_conn;

namespace enfilade::bench {

struct TableSize {
  std::string name;
  std::int64_t bytes = 0;        // without indexes
  std::int64_t index_bytes = 0;  // of all its indexes
  std::int64_t dead_rows = 0;    // as the database estimates them: not yet vacuumed
};

// What a server and its database use and hold, and how far mapping is behind, at one moment.
struct ResourceSample {
  double at = 0.0;                  // s
  std::int64_t server_bytes = 0;    // resident
  int server_files = 0;             // open
  double server_cpu_s = 0.0;        // since its start
  double database_cpu_s = 0.0;      // of all processes of the cluster
  int connections = 0;              // of the server to the database
  std::int64_t database_bytes = 0;  // tables and indexes, those of the catalogue included
  // Acknowledged and not yet mapped, those of sessions that wait for their map included.
  std::int64_t backlog_records = 0;
  std::int64_t backlog_sessions = 0;  // with such records
  std::vector<TableSize> tables;      // by name
};

// Takes samples until Stop.
class ResourceSampler {
 public:
  ResourceSampler(pid_t server, pid_t database, const std::string& database_url, std::chrono::duration<double> every);
  ~ResourceSampler();
  ResourceSampler(const ResourceSampler&) = delete;
  ResourceSampler& operator=(const ResourceSampler&) = delete;

  std::vector<ResourceSample> Stop();

  // After Stop. Throws if the database does not answer.
  ResourceSample Take();

 private:
  struct Disconnect {
    void operator()(pg_conn* connection) const;
  };
  std::vector<std::vector<std::string>> Query(const std::string& sql);

  const pid_t server_;
  const pid_t database_;
  const std::chrono::steady_clock::time_point start_;
  std::unique_ptr<pg_conn, Disconnect> connection_;  // of the worker while it runs
  std::vector<ResourceSample> samples_;
  Mutex mutex_;
  CondVar changed_;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread worker_;
};

nlohmann::json ToJson(const ResourceSample& sample);

// The names of the tables that are the largest at any time, with their indexes.
std::vector<std::string> LargestTables(const std::vector<ResourceSample>& samples, std::size_t count);

// The largest tables at each tenth of the time: a list of MiB without indexes, of indexes, and of dead rows.
nlohmann::json TablesToJson(const std::vector<ResourceSample>& samples, std::size_t count);

// One panel for each of memory, files and connections, processor time, sizes of the database, its tables and indexes,
// and backlog, over time, as SVG.
std::string DrawSamples(const std::vector<ResourceSample>& samples);

}  // namespace enfilade::bench

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/bench/fleet/resource_samples.h"

namespace enfilade::bench {
namespace {

constexpr std::size_t kPeriods = 10;

// To a tenth.
double MiB(std::int64_t bytes) { return std::round(10.0 * static_cast<double>(bytes) / (1 << 20)) / 10.0; }

}  // namespace

std::vector<std::string> LargestTables(const std::vector<ResourceSample>& samples, std::size_t count) {
  std::map<std::string, std::int64_t> largest;
  for (const ResourceSample& sample : samples) {
    for (const TableSize& table : sample.tables) {
      std::int64_t& bytes = largest[table.name];
      bytes = std::max(bytes, table.bytes + table.index_bytes);
    }
  }
  std::vector<std::pair<std::int64_t, std::string>> order;
  for (const auto& [name, bytes] : largest) order.emplace_back(-bytes, name);
  std::sort(order.begin(), order.end());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(count, order.size()); ++i) names.push_back(order[i].second);
  return names;
}

nlohmann::json TablesToJson(const std::vector<ResourceSample>& samples, std::size_t count) {
  nlohmann::json document = nlohmann::json::object();
  if (samples.empty()) return document;
  for (const std::string& name : LargestTables(samples, count)) {
    for (std::size_t i = 0; i <= kPeriods; ++i) {
      for (const TableSize& table : samples[i * (samples.size() - 1) / kPeriods].tables) {
        if (table.name != name) continue;
        document[name]["mib"].push_back(MiB(table.bytes));
        document[name]["index_mib"].push_back(MiB(table.index_bytes));
        document[name]["dead_rows"].push_back(table.dead_rows);
      }
    }
  }
  return document;
}

nlohmann::json ToJson(const ResourceSample& sample) {
  return {{"at_s", sample.at},
          {"server_mib", MiB(sample.server_bytes)},
          {"server_files", sample.server_files},
          {"server_cpu_s", sample.server_cpu_s},
          {"database_cpu_s", sample.database_cpu_s},
          {"connections", sample.connections},
          {"database_mib", MiB(sample.database_bytes)},
          {"backlog_records", sample.backlog_records},
          {"backlog_sessions", sample.backlog_sessions}};
}

}  // namespace enfilade::bench

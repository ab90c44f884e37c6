// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/cluster.h"
#include "tests/support/server_process.h"
#include "tests/support/test_data.h"

namespace enfilade::bench {

// A durable database cluster and a server of their own, with one site and one robot.
class BenchSystem {
 public:
  // `settings` of the server: KEY=VALUE. Throws where something does not start.
  explicit BenchSystem(std::vector<std::string> settings = {});

  const std::string& database_url() const { return cluster_.url(); }
  pid_t database_pid() const { return cluster_.pid(); }
  testing::ServerProcess& server() { return server_; }
  const std::filesystem::path& directory() const { return directory_.path(); }

  // New sessions that are only recorded, as resource names.
  std::vector<std::string> CreateSessions(int count);
  // A new map's resource name.
  std::string CreateMap(const std::string& display_name);
  // Waits until the server has solved the graph of `site` (a resource name) and has it in memory, as it has any site
  // that is in use. Returns the solution's graph version.
  std::int64_t Settle(const std::string& site);

 private:
  testing::TemporaryDirectory directory_;
  testing::Cluster cluster_;
  testing::ServerProcess server_;
  int sessions_ = 0;
};

}  // namespace enfilade::bench

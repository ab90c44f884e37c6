// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "client/sdk/connection.h"
#include "tests/support/eventually.h"
#include "tests/support/process.h"

namespace enfilade::testing {

enum class Health { kServing, kNotServing, kUnreachable };

// The health of the whole server by grpc.health.v1.
Health HealthOf(const client::Connection& connection);

// enfilade-server as a separate process on a Unix socket. It can be killed and started again at the same address.
class ServerProcess {
 public:
  // `directory`: for its socket, log and files; `name` is unique in it. `settings`: KEY=VALUE.
  ServerProcess(const std::filesystem::path& directory, const std::string& name, std::string database_url,
                std::vector<std::string> settings = {});

  // Starts it, without waiting until it is ready. No-op if it is running.
  void Start();
  // Starts it and waits until its health is kServing. Throws with the end of its log if it ends instead.
  void StartAndWait();
  void Kill() { process_->Kill(); }
  Process& process() { return *process_; }

  const std::string& address() const { return address_; }
  std::filesystem::path log() const { return log_; }
  client::Connection Connect() const { return {address_, std::chrono::seconds(30)}; }

 private:
  const std::string address_;
  const std::filesystem::path log_;
  std::vector<std::string> command_;
  std::vector<std::string> environment_;
  std::unique_ptr<Process> process_;
};

// The end of a text file, for failure messages.
std::string TailOf(const std::filesystem::path& file);

}  // namespace enfilade::testing

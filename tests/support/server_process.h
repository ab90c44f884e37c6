// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "client/sdk/connection.h"
#include "tests/support/process.h"

namespace enfilade::testing {

enum class Health { kServing, kNotServing, kUnreachable };

// What grpc.health.v1 says of the whole server.
Health HealthOf(const client::Connection& connection);

// enfilade-server as a process of its own on a Unix socket. It may be killed and started again at the same address.
class ServerProcess {
 public:
  // `directory`: for its socket, log and files; `name` tells several in one directory apart. `settings`: KEY=VALUE.
  ServerProcess(const std::filesystem::path& directory, const std::string& name, std::string database_url,
                std::vector<std::string> settings = {});

  // Starts it; ready or not, it listens soon. Nothing where it is running.
  void Start();
  // Start, and waits until its health is kServing. Throws with the end of its log where it ends instead.
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

// The end of a text file, for messages of failures.
std::string TailOf(const std::filesystem::path& file);

// Waits until `condition` holds; false after a time that is long for anything a test waits for.
template <typename Condition>
bool Eventually(const Condition& condition, std::chrono::seconds limit = std::chrono::seconds(60)) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace enfilade::testing

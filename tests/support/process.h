// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace enfilade::testing {

// A program started by a test, with stdout and stderr appended to a file. The destructor kills it, and so does the
// kernel when the thread that started it ends, so that it never outlives the test.
class Process {
 public:
  // `environment`: "NAME=value", added to this process's. Throws if the program cannot be started.
  Process(const std::vector<std::string>& command, const std::filesystem::path& output,
          const std::vector<std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  // Does nothing once it has ended.
  void Signal(int signal);
  // Its exit code, or 128 + the signal that ended it; nullopt: it is still running after `timeout`.
  std::optional<int> Wait(std::chrono::milliseconds timeout);
  bool running() { return !Wait(std::chrono::milliseconds(0)); }
  // kill -9, and waits until it has ended.
  void Kill();

 private:
  pid_t pid_ = 0;
  std::optional<int> exit_code_;
};

// VmRSS or VmHWM (its peak) of a process, bytes; 0: there is no such process.
std::int64_t ResidentBytes(pid_t pid, const std::string& field = "VmRSS");

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace enfilade::testing {

// A throwaway PostgreSQL cluster of this test program, made by deploy/database/cluster. A second process stops and
// removes it as soon as this one has ended, also when it was killed.
class Cluster {
 public:
  // kFast: what is lost when the machine dies does not matter (fsync off); kDurable: settings as in service.
  enum class Durability { kFast, kDurable };

  // Starts a new one.
  explicit Cluster(Durability durability);
  ~Cluster();
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  // The one that the program's tests share; starts it at the first call.
  static Cluster& Instance();

  const std::string& url() const { return url_; }
  // The server's process.
  pid_t pid() const;
  // Starts it again where the test has killed it.
  void Restart();

 private:
  void StartGuard();
  void Start();

  std::filesystem::path directory_;
  std::string url_;
  int guard_pipe_ = -1;  // the guard acts when its other end closes
  pid_t guard_ = 0;
};

}  // namespace enfilade::testing

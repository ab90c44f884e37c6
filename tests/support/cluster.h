// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace enfilade::testing {

// A temporary PostgreSQL cluster of this test program, created by deploy/database/cluster. A second process stops and
// removes it as soon as this one has ended, even if it was killed.
class Cluster {
 public:
  // kFast: data may be lost if the machine crashes (fsync off); kDurable: the settings of production.
  enum class Durability { kFast, kDurable };

  // Starts a new one.
  explicit Cluster(Durability durability);
  ~Cluster();
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  // The cluster that the program's tests share; the first call starts it.
  static Cluster& Instance();

  const std::string& url() const { return url_; }
  // The server's process.
  pid_t pid() const;
  // Starts it again after the test has killed it.
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

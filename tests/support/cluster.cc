// SPDX-License-Identifier: Apache-2.0
#include "tests/support/cluster.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "tests/support/command.h"

namespace enfilade::testing {
namespace {

namespace fs = std::filesystem;

// Waits for the end of its input, which this process keeps open as long as it runs.
constexpr char kGuardScript[] = R"sh(
  read -r _
  pid=$(head -n 1 "$1/data/postmaster.pid" 2>/dev/null)
  if [ -n "$pid" ] && [ "$(readlink "/proc/$pid/cwd")" = "$1/data" ]; then
    kill -QUIT "$pid"
    for _ in $(seq 100); do
      [ "$(readlink "/proc/$pid/cwd")" = "$1/data" ] || break
      sleep 0.1
    done
  fi
  rm -rf "$1"
)sh";

}  // namespace

Cluster& Cluster::Instance() {
  static Cluster cluster(Durability::kFast);
  return cluster;
}

Cluster::Cluster(Durability durability) {
  std::string name = (fs::temp_directory_path() / "enfilade-db-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("cannot make a temporary directory " + name);
  directory_ = name;
  fs::permissions(directory_,
                  fs::perms(0755));  // if root runs the tests, the server runs as postgres and must be able to enter it
  StartGuard();
  std::ofstream settings(directory_ / "test.conf");
  if (durability == Durability::kFast) {
    settings << "fsync = off\nfull_page_writes = off\nshared_buffers = 64MB\nmax_wal_size = 512MB\n"
                "autovacuum_naptime = 10s\n";
  }
  settings.close();
  Start();
}

Cluster::~Cluster() {
  close(guard_pipe_);
  waitpid(guard_, nullptr, 0);
}

void Cluster::StartGuard() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe");
  guard_ = fork();
  if (guard_ < 0) throw std::runtime_error("cannot start the cluster's guard");
  if (guard_ == 0) {
    setsid();  // signals to the test's process group do not reach it
    dup2(ends[0], STDIN_FILENO);
    execl("/bin/sh", "sh", "-c", kGuardScript, "sh", directory_.c_str(), nullptr);
    _exit(127);
  }
  close(ends[0]);
  guard_pipe_ = ends[1];
}

void Cluster::Start() {
  const CommandResult started = RunCommand({ProjectFile("deploy/database/cluster"), "start", directory_.string()},
                                           {"ENFILADE_PG_CONF=" + (directory_ / "test.conf").string()});
  if (started.exit_code != 0) throw std::runtime_error("no database for tests:\n" + started.output);
  url_ = RunCommand({ProjectFile("deploy/database/cluster"), "url", directory_.string()}).output;
  url_.erase(url_.find_last_not_of('\n') + 1);
}

void Cluster::Restart() { Start(); }

pid_t Cluster::pid() const {
  pid_t pid = 0;
  std::ifstream(directory_ / "data/postmaster.pid") >> pid;
  return pid;
}

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace enfilade::testing {

// Forwards bytes between a client and a server, both on Unix sockets, and closes connections after a given number of
// bytes, which may be in the middle of a message, a frame or the handshake. Or it is slow to begin.
class CuttingProxy {
 public:
  struct Cut {
    std::int64_t upstream_bytes = -1;    // from the client, on one connection; -1: never
    std::int64_t downstream_bytes = -1;  // from the server
    std::chrono::milliseconds delay{0};  // before anything is forwarded
  };

  // The first connection gets the first cut, and so on. Connections after the last cut are not closed.
  CuttingProxy(std::string listen_path, std::string server_path, std::vector<Cut> cuts);
  ~CuttingProxy();
  CuttingProxy(const CuttingProxy&) = delete;
  CuttingProxy& operator=(const CuttingProxy&) = delete;

  std::string address() const { return "unix:" + listen_path_; }
  int connections();
  int cuts_made();

 private:
  void Accept();
  void Serve(int client, int server, Cut cut);
  // False: the connection has ended. `left` counts down; at zero the connection is closed.
  bool Forward(int from, int to, std::int64_t& left);

  const std::string listen_path_;
  const std::string server_path_;
  int listener_;
  int stop_pipe_[2];
  std::thread acceptor_;

  Mutex mutex_;
  std::deque<Cut> cuts_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> connections_ ABSL_GUARDED_BY(mutex_);
  int cuts_made_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::storage::postgres {

class Connection;

// One of the servers that a URL names, as libpq's parameters. Empty: not given.
struct Host {
  std::string host;
  std::string hostaddr;
  std::string port;

  friend bool operator==(const Host&, const Host&) = default;
};

// The hosts of a URL or keyword string in their order; one without parameters if it names none, or if libpq must choose
// among them itself (target_session_attrs=prefer-standby).
std::vector<Host> HostsOf(const std::string& url);

// Opens connections to the first host of a URL that accepts one. libpq goes to the next host when one refuses, but
// waits for one that swallows packets as long as it may: here each host has its share of the time. The last good one is
// tried first. Thread-safe.
class HostList {
 public:
  explicit HostList(std::string url) : url_(std::move(url)), hosts_(HostsOf(url_)) {}

  // As Connection::Open; of several errors the last one.
  absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& application_name,
                                                   std::chrono::steady_clock::time_point deadline);

 private:
  const std::string url_;
  const std::vector<Host> hosts_;
  std::atomic<std::size_t> last_good_ = 0;
};

}  // namespace enfilade::storage::postgres

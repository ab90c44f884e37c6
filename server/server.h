// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/slam/slam_profiles.h"
#include "server/config/server_options.h"

namespace enfilade::server {

// The whole server: everything built, wired together and listening.
class Server {
 public:
  // The database need not be reachable yet: then health says NOT_SERVING until it is. UNAVAILABLE where an address is
  // taken, saying which; INVALID_ARGUMENT for options.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options, const slam::SlamProfiles& slam);
  // Shuts down at once, if Shutdown was not called.
  ~Server();

  // Where it listens: with the port that was chosen for port 0.
  const std::string& address() const;

  // Health off; streams are answered and ended; unary calls finish; mapping stores its checkpoints. Returns when all is
  // done, after the grace time at the latest, when what is left is cut off.
  void Shutdown();

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::server

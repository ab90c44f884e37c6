// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/slam/slam_profiles.h"
#include "server/config/server_options.h"

namespace enfilade::server {

// The whole server: constructs the services, connects them and listens.
class Server {
 public:
  // The database need not be reachable yet: health is NOT_SERVING until it is. UNAVAILABLE naming an address that is in
  // use; INVALID_ARGUMENT for invalid options.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options, const slam::SlamProfiles& slam);
  // Calls Shutdown.
  ~Server();

  // The listening address; with port 0 in the options, the port that was chosen.
  const std::string& address() const;

  // Sets health to NOT_SERVING, answers and ends streams, finishes unary calls, and stores mapping's checkpoints.
  // Returns when all is done; after the grace time, remaining calls are cancelled.
  void Shutdown();

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::server

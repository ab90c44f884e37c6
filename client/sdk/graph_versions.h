// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "grpcpp/client_context.h"

namespace enfilade::client {

// The greatest version of each site's graph that a client's own changes have made. Sent with its later calls, it makes
// every server answer from that version or a later one. Keeps it for a minute, in which every server has long heard of
// the change, and of a bounded number of sites: a site may be deleted and begin anew. Thread-safe.
class GraphVersions {
 public:
  // The answer's metadata "enfilade-graph-version", after the call.
  void Note(const grpc::ClientContext& context);
  // As metadata "enfilade-min-graph-version", before the call.
  void Send(grpc::ClientContext& context) const;

 private:
  struct Version {
    std::int64_t version = 0;
    std::chrono::steady_clock::time_point noted = {};
  };

  mutable Mutex mutex_;
  std::map<std::string, Version> versions_ ABSL_GUARDED_BY(mutex_);  // by the site's resource name
};

}  // namespace enfilade::client

// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/graph_listener.h"

#include <charconv>
#include <string>

#include "core/base/status_macros.h"
#include "storage/postgres/driver/connection.h"
#include "storage/postgres/driver/params.h"
#include "storage/postgres/graph/graph_versions.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kListen{"listening for changes of graphs", "LISTEN " ENFILADE_GRAPH_CHANNEL};

}  // namespace

absl::StatusOr<std::unique_ptr<storage::GraphListener>> GraphListener::Open(Pool& pool, const CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(Pool::Lease lease, pool.Acquire(context));
  lease->Queue(kListen, Params());
  ENFILADE_RETURN_IF_ERROR(lease->Flush(context).status());
  return std::unique_ptr<storage::GraphListener>(new GraphListener(std::move(lease)));
}

// The pool must not hand out a connection that listens.
GraphListener::~GraphListener() { lease_->Retire(); }

absl::StatusOr<std::vector<GraphListener::Change>> GraphListener::Await(const CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(const auto payloads, lease_->AwaitNotifications(context.deadline));
  std::vector<Change> changes;
  for (const std::string& payload : payloads) {
    const std::size_t space = payload.find(' ');
    if (space == std::string::npos) continue;
    Change change{SiteId(payload.substr(0, space)), 0};
    std::from_chars(payload.data() + space + 1, payload.data() + payload.size(), change.version);
    changes.push_back(std::move(change));
  }
  return changes;
}

}  // namespace enfilade::storage::postgres

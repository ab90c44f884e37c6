// SPDX-License-Identifier: Apache-2.0
#include <charconv>

#include "storage/graph_store.h"
#include "storage/postgres/driver/connection.h"
#include "storage/postgres/driver/pool.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

constexpr postgres::Statement kListen{"listening for changes of graphs", "LISTEN enfilade_graph"};

}  // namespace

struct GraphListener::Impl {
  postgres::Pool::Lease lease;
};

GraphListener::GraphListener(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
// Nobody else should be given a connection that listens.
GraphListener::~GraphListener() { impl_->lease->Retire(); }

absl::StatusOr<std::unique_ptr<GraphListener>> GraphListener::Open(postgres::Pool& pool, const CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(postgres::Pool::Lease lease, pool.Acquire(context));
  lease->Queue(kListen, postgres::Params());
  ENFILADE_RETURN_IF_ERROR(lease->Flush(context.deadline).status());
  return std::unique_ptr<GraphListener>(new GraphListener(std::make_unique<Impl>(Impl{std::move(lease)})));
}

absl::StatusOr<std::vector<GraphListener::Change>> GraphListener::Await(const CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(const auto payloads, impl_->lease->AwaitNotifications(context.deadline));
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

}  // namespace enfilade::storage

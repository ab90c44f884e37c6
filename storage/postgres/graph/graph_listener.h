// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/graph/graph_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

// Holds one connection of the pool.
class GraphListener final : public storage::GraphListener {
 public:
  static absl::StatusOr<std::unique_ptr<storage::GraphListener>> Open(Pool& pool, const CallContext& context);
  ~GraphListener() override;

  absl::StatusOr<std::vector<Change>> Await(const CallContext& context) override;

 private:
  explicit GraphListener(Pool::Lease lease) : lease_(std::move(lease)) {}

  Pool::Lease lease_;
};

}  // namespace enfilade::storage::postgres

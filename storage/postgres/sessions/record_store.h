// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/postgres/driver/pool.h"
#include "storage/sessions/record_store.h"

namespace enfilade::storage::postgres {

class RecordStore final : public storage::RecordStore {
 public:
  explicit RecordStore(Pool& pool) : pool_(pool) {}

  std::vector<absl::StatusOr<AppendResult>> AppendGroup(const CallContext& context,
                                                        absl::Span<const RecordBatch> batches) const override;
  absl::StatusOr<std::vector<sensor::Record>> Read(const CallContext& context, const SiteId& site,
                                                   const SessionId& session, std::int64_t from_sequence,
                                                   std::int64_t max_bytes) const override;
  absl::StatusOr<std::vector<sensor::Record>> ReadSelected(const CallContext& context, const SiteId& site,
                                                           const SessionId& session,
                                                           const RecordSelection& selection) const override;
  absl::StatusOr<std::vector<sensor::Record>> ReadEach(const CallContext& context, const SiteId& site,
                                                       const SessionId& session,
                                                       const std::vector<std::int64_t>& sequences) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres

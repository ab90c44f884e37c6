// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "storage/graph/survey_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class SurveyStore : public storage::SurveyStore {
 public:
  explicit SurveyStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<std::vector<PendingSurvey>> FindPending(const CallContext& context) const override;
  absl::Status MarkSurveyed(const CallContext& context, const SiteLease& lease,
                            const std::vector<SessionId>& sessions) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres

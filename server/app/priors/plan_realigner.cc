// SPDX-License-Identifier: Apache-2.0
#include "server/app/priors/plan_realigner.h"

#include <algorithm>
#include <vector>

#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr std::int64_t kLooked = 100;             // plans that may be due
constexpr auto kTime = std::chrono::minutes(10);  // for one

}  // namespace

absl::StatusOr<std::int64_t> PlanRealigner::AlignOne(const storage::CallContext& context) {
  const Clock::time_point now = Clock::now();
  std::erase_if(tried_, [&](const auto& one) { return one.second + interval_ <= now; });
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::PriorMap> outgrown,
                            store_.ListOutgrown(context, interval_, kLooked));
  const auto due = std::find_if(outgrown.begin(), outgrown.end(), [&](const storage::PriorMap& prior_map) {
    return !tried_.contains({prior_map.site, prior_map.id});
  });
  if (due == outgrown.end()) return 0;
  tried_[{due->site, due->id}] = now;
  const absl::Status status = Align(*due);
  if (!status.ok()) return WithContext(status, NameOf(due->site, due->id));
  return 1;
}

absl::Status PlanRealigner::Align(const storage::PriorMap& prior_map) const {
  const storage::CallContext context = storage::CallContext::WithTimeout(kTime);
  ENFILADE_ASSIGN_OR_RETURN(const AlignedPriorMap aligned, alignment_.AlignAgain(context, prior_map));
  const absl::Status stored =
      store_.SetOutcome(context, prior_map.site, prior_map.id, prior_map.etag, aligned.outcome).status();
  // Somebody has changed it meanwhile, or another process was faster.
  if (absl::IsAborted(stored)) return absl::OkStatus();
  if (stored.ok() && !aligned.outcome.alignment) {
    spdlog::warn("{} is no longer used: {}", NameOf(prior_map.site, prior_map.id), aligned.outcome.reason);
  }
  return stored;
}

MaintenanceJob PlanRealigner::Job() {
  return {"plans whose maps have grown",
          [this](const storage::CallContext& context, std::int64_t) { return AlignOne(context); }, "aligned"};
}

}  // namespace enfilade::server

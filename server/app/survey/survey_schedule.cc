// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/survey_schedule.h"

#include <algorithm>

namespace enfilade::server {
namespace {

constexpr auto kRetry = std::chrono::seconds(2);
constexpr int kMaxDoublings = 5;  // of the wait

}  // namespace

bool SurveySchedule::IsDue(const storage::PendingSurvey& pending, Clock::time_point now) const {
  const auto found = sites_.find(pending.site);
  if (found == sites_.end()) return true;
  const Site& site = found->second;
  if (site.failures > 0) return now >= site.retry;
  if (pending.drive_ended || now - site.surveyed >= options_.interval) return true;
  return !pending.mapping_lags &&
         static_cast<double>(pending.sessions) >= options_.growth * static_cast<double>(site.sessions);
}

void SurveySchedule::CountSurvey(const SiteId& site, std::size_t sessions, Clock::time_point time) {
  sites_[site] = {.sessions = sessions, .surveyed = time, .failures = 0, .retry = {}};
}

int SurveySchedule::CountFailure(const SiteId& site, Clock::time_point time) {
  Site& failing = sites_[site];
  ++failing.failures;
  failing.retry = time + kRetry * (1 << std::clamp(failing.failures - kUsualFailures, 0, kMaxDoublings));
  return failing.failures;
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <map>

#include "core/base/ids.h"
#include "storage/graph/survey_store.h"

namespace enfilade::server {

struct SurveyScheduleOptions {
  // While robots record at a site, it is surveyed again once as many sessions are new as this share of those that the
  // last survey has seen, ...
  double growth = 1.0;
  // ... unless mapping lags behind: what a survey finds then is soon outdated, and mapping needs the processor. At the
  // latest this long after the last one.
  std::chrono::duration<double> interval{300.0};
};

// When sites with new sessions are surveyed. A survey's cost grows with its site, so that surveys each time that a site
// has grown by a share cost a constant multiple of the last one, however long robots drive. A robot that has ended its
// drive does not wait. Not thread-safe.
class SurveySchedule {
 public:
  using Clock = std::chrono::steady_clock;

  // What robots do meanwhile makes so many fail in a row. After that, each wait is twice as long as the last one.
  static constexpr int kUsualFailures = 10;

  explicit SurveySchedule(const SurveyScheduleOptions& options) : options_(options) {}

  // A site of which nothing is known is due.
  bool IsDue(const storage::PendingSurvey& pending, Clock::time_point now) const;

  // A survey that began at `time` has seen `sessions` sessions, new or not.
  void CountSurvey(const SiteId& site, std::size_t sessions, Clock::time_point time);
  // A survey has failed: the next one must wait for a moment, and longer if many have failed in a row. Returns how many
  // have.
  int CountFailure(const SiteId& site, Clock::time_point time);

 private:
  struct Site {
    std::size_t sessions = 0;
    Clock::time_point surveyed;
    int failures = 0;         // since the last survey
    Clock::time_point retry;  // not before, if one has failed
  };
  const SurveyScheduleOptions options_;
  std::map<SiteId, Site> sites_;
};

}  // namespace enfilade::server

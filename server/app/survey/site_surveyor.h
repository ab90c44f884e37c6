// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/survey/survey_options.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/rearrange/rearranger.h"
#include "server/app/runtime/stop_signal.h"
#include "server/app/runtime/wake_signal.h"
#include "server/app/survey/drive_mapping.h"
#include "server/app/survey/site_cache.h"
#include "server/app/survey/survey_schedule.h"
#include "storage/graph/site_lease_store.h"
#include "storage/graph/survey_store.h"

namespace enfilade::server {

struct SurveyLoad {
  double share = 0.25;           // the largest share of the time that it surveys, above 0 and up to 1
  std::int64_t cache_bytes = 0;  // for what the last surveys have mapped; the last site's is kept even if it is larger
};

// Surveys sites whose sessions are mapped, and rearranges their maps until each is one room (core/survey). One thread;
// it rests for a multiple of the time that a survey took, so that surveys cost a bounded share of a processor however
// many sites there are. Idempotent: a survey of a site that is arranged already changes nothing.
class SiteSurveyor {
 public:
  struct Stores {
    SurveyStores read;
    const storage::SurveyStore& surveys;
    const storage::SiteLeaseStore& leases;
  };

  // `wake` wakes it when a session may have been mapped or judged.
  SiteSurveyor(const survey::SurveyOptions& options, const SurveyScheduleOptions& schedule, const SurveyLoad& load,
               const SurveyMappingOptions& mapping, const Stores& stores, SiteGraphs& graphs,
               const Rearranger& rearranger, WakeSignal& wake);
  ~SiteSurveyor();
  SiteSurveyor(const SiteSurveyor&) = delete;
  SiteSurveyor& operator=(const SiteSurveyor&) = delete;

  // Starts stopping; the destructor waits for it.
  void Stop();

 private:
  using Clock = std::chrono::steady_clock;

  void Run();
  enum class Found { kNothing, kWaiting, kDue };
  // Surveys the site that has waited longest, of those that are due.
  Found SurveyPending();
  void CountFailure(const SiteId& site, const absl::Status& status);
  // Until nothing more changes. Returns how many sessions it has seen.
  absl::StatusOr<std::size_t> Survey(const SiteId& site);
  // Unset if maps were rearranged: survey again.
  absl::StatusOr<std::optional<std::size_t>> SurveyOnce(const SiteId& site);
  // True if something has changed.
  absl::StatusOr<bool> Apply(const storage::SiteLease& lease, const SiteSurvey& survey, SiteCache& cache);

  const survey::SurveyOptions options_;
  const double share_;
  const SurveyMappingOptions mapping_;
  const Stores stores_;
  SiteGraphs& graphs_;
  const Rearranger& rearranger_;
  WakeSignal& wake_;
  const std::string owner_;
  StopSignal stop_;
  SiteCaches caches_;        // the worker's only
  SurveySchedule schedule_;  // the worker's only
  std::thread worker_;
};

}  // namespace enfilade::server

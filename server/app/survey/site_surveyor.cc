// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/site_surveyor.h"

#include <malloc.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/rooms/room_partition.h"
#include "core/survey/arrange_maps.h"
#include "server/app/graph/held_site_lease.h"
#include "server/app/runtime/thread_priority.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

// What other replicas have mapped and judged does not wake this process.
constexpr auto kIdlePoll = std::chrono::seconds(2);
// Sites become due without further notice.
constexpr auto kWaitingPoll = std::chrono::milliseconds(500);
constexpr auto kSurveyStoreTimeout = std::chrono::seconds(60);
constexpr auto kLeaseTime = std::chrono::seconds(60);
// What has changed is surveyed again, because maps that are rearranged may be seen differently.
constexpr int kSurveysInARow = 50;

storage::CallContext SurveyorContext() {
  storage::CallContext context = storage::CallContext::WithTimeout(kSurveyStoreTimeout);
  context.actor = "survey of the site";
  return context;
}

}  // namespace

SiteSurveyor::SiteSurveyor(const survey::SurveyOptions& options, const SurveyScheduleOptions& schedule,
                           const SurveyLoad& load, const SurveyMappingOptions& mapping, const Stores& stores,
                           SiteGraphs& graphs, const Rearranger& rearranger, WakeSignal& wake)
    : options_(options),
      share_(load.share),
      mapping_(mapping),
      stores_(stores),
      graphs_(graphs),
      rearranger_(rearranger),
      wake_(wake),
      owner_(NewUuid() + "/survey"),
      caches_(static_cast<std::size_t>(load.cache_bytes)),
      schedule_(schedule) {
  worker_ = std::thread([this] { Run(); });
}

SiteSurveyor::~SiteSurveyor() {
  Stop();
  worker_.join();
}

void SiteSurveyor::Stop() {
  stop_.Set();
  wake_.Wake();
}

void SiteSurveyor::Run() {
  SetThreadNiceness(kBackgroundNiceness);
  while (!stop_.is_set()) {
    const Found found = SurveyPending();
    if (found != Found::kDue) wake_.WaitFor(found == Found::kWaiting ? kWaitingPoll : kIdlePoll);
  }
}

SiteSurveyor::Found SiteSurveyor::SurveyPending() {
  const auto pending = stores_.surveys.FindPending(SurveyorContext());
  if (!pending.ok()) return Found::kNothing;  // readiness reports an unreachable database
  const Clock::time_point begin = Clock::now();
  const auto due = std::find_if(pending->begin(), pending->end(),
                                [&](const storage::PendingSurvey& one) { return schedule_.IsDue(one, begin); });
  if (due == pending->end()) return pending->empty() ? Found::kNothing : Found::kWaiting;
  const absl::StatusOr<std::size_t> sessions = Survey(due->site);
  caches_.Trim();
  // A survey works with large grids. Freed, they would stay with this thread's part of the heap.
  malloc_trim(0);
  if (sessions.ok()) {
    schedule_.CountSurvey(due->site, *sessions, begin);
  } else if (!stop_.is_set()) {
    CountFailure(due->site, sessions.status());
  }
  stop_.WaitFor(std::chrono::duration_cast<Clock::duration>((Clock::now() - begin) * ((1.0 - share_) / share_)));
  return Found::kDue;
}

void SiteSurveyor::CountFailure(const SiteId& site, const absl::Status& status) {
  const int failures = schedule_.CountFailure(site, Clock::now());
  // That robots have changed the graph meanwhile is usual, unless it goes on.
  const bool usual =
      (absl::IsAborted(status) || absl::IsFailedPrecondition(status)) && failures % SurveySchedule::kUsualFailures != 0;
  spdlog::log(usual ? spdlog::level::debug : spdlog::level::warn, "the survey of site {}: {}; will retry", site.value(),
              status.ToString());
}

absl::StatusOr<std::size_t> SiteSurveyor::Survey(const SiteId& site) {
  for (int i = 0; i < kSurveysInARow; ++i) {
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<std::size_t> sessions, SurveyOnce(site));
    if (sessions) return *sessions;
  }
  return Internal("after {} surveys the maps still change", kSurveysInARow);
}

absl::StatusOr<std::optional<std::size_t>> SiteSurveyor::SurveyOnce(const SiteId& site) {
  const Clock::time_point begin = Clock::now();
  ENFILADE_ASSIGN_OR_RETURN(auto graph, graphs_.Get(SurveyorContext(), site));
  SiteCache& cache = caches_.Get(site);
  const std::function<absl::Status()> proceed = [this]() -> absl::Status {
    return stop_.is_set() ? absl::CancelledError("the server is stopping") : absl::OkStatus();
  };
  ENFILADE_ASSIGN_OR_RETURN(SiteSurvey survey,
                            MapSite(stores_.read, mapping_, *graph, site, {cache.drives, false, proceed}));
  ENFILADE_ASSIGN_OR_RETURN(const HeldSiteLease lease,
                            HeldSiteLease::Await(stores_.leases, SurveyorContext(), site, owner_, kLeaseTime, &stop_));
  // What verdicts have changed meanwhile. There are none from now on, so this must be fast.
  ENFILADE_ASSIGN_OR_RETURN(graph, graphs_.Get(SurveyorContext(), site));
  if (graph->graph().version() != survey.graph_version) {
    ENFILADE_ASSIGN_OR_RETURN(survey, MapSite(stores_.read, mapping_, *graph, site, {cache.drives, true, proceed}));
  }
  ENFILADE_ASSIGN_OR_RETURN(const bool changed, Apply(*lease, survey, cache));
  if (!changed) {
    ENFILADE_RETURN_IF_ERROR(stores_.surveys.MarkSurveyed(SurveyorContext(), *lease, survey.sessions));
  }
  const std::chrono::duration<double> took = Clock::now() - begin;
  spdlog::info("site {} surveyed: {} sessions on {} levels in {:.1f} s", site.value(), survey.sessions.size(),
               survey.levels.size(), took.count());
  return changed ? std::nullopt : std::optional(survey.sessions.size());
}

absl::StatusOr<bool> SiteSurveyor::Apply(const storage::SiteLease& lease, const SiteSurvey& survey, SiteCache& cache) {
  for (const MappedLevel& level : survey.levels) {
    const rooms::RoomPartition& partition =
        cache.rooms[level.survey.level].Get(level.grid, level.passages, level.trajectory);
    const rearrange::Rearrangement rearrangement = survey::ArrangeMaps(level.survey, partition, options_, NewUuid);
    if (rearrangement.empty()) continue;
    // The other levels share link points and cabins of lifts with this one: they are surveyed again.
    ENFILADE_RETURN_IF_ERROR(rearranger_.Apply(SurveyorContext(), lease, rearrangement, survey.graph_version).status());
    return true;
  }
  return false;
}

}  // namespace enfilade::server

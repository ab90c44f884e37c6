// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/door_closures.h"

#include <algorithm>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/closure/door_action.h"
#include "fmt/ranges.h"
#include "server/app/closure/apply_door_action.h"
#include "server/app/closure/judge_report.h"
#include "server/app/closure/judging_lease.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

// Mapping by other replicas does not wake this process, so it polls; more often while something waits.
constexpr auto kIdlePoll = std::chrono::seconds(2);
constexpr auto kJudgingPoll = std::chrono::milliseconds(500);
constexpr auto kBusyPoll = std::chrono::milliseconds(50);
constexpr auto kEarlyPoll = std::chrono::seconds(2);
constexpr int kPendingAtOnce = 32;
// The graph may change while a report is judged: people edit it.
constexpr int kJudgingAttempts = 10;

// What robots have seen of the rooms around a few dozen doors.
constexpr std::size_t kGroundBytes = 128 << 20;

// What is known of a session that has not been pending for so long is forgotten.
constexpr auto kForgetAfter = std::chrono::hours(1);

std::pair<SiteId, SessionId> KeyOf(const storage::PendingDoors& pending) { return {pending.site, pending.session}; }

}  // namespace

DoorClosures::DoorClosures(const closure::DoorClosureOptions& options, const DoorClosureStores& stores,
                           SiteGraphs& graphs, WakeSignal& wake, Listeners listeners)
    : options_(options),
      stores_(stores),
      graphs_(graphs),
      wake_(wake),
      listeners_(std::move(listeners)),
      grounds_(kGroundBytes),
      owner_(NewUuid() + "/doors") {
  worker_ = std::thread([this] { Run(); });
}

DoorClosures::~DoorClosures() {
  Stop();
  worker_.join();
}

void DoorClosures::Stop() {
  stop_.Set();
  wake_.Wake();
}

void DoorClosures::Run() {
  while (!stop_.is_set()) {
    if (JudgePending()) continue;
    if (!busy_until_.empty()) {
      wake_.WaitFor(kBusyPoll);
    } else {
      wake_.WaitFor(delays_.empty() ? kIdlePoll : kJudgingPoll);
    }
  }
}

double DoorClosures::SecondsWaited(const storage::PendingDoors& pending) const {
  const auto found = delays_.find(KeyOf(pending));
  if (found == delays_.end() || !found->second.waiting_since) return 0.0;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - *found->second.waiting_since).count();
}

void DoorClosures::Postpone(const storage::PendingDoors& pending) {
  Delay& delay = delays_[KeyOf(pending)];
  const auto now = std::chrono::steady_clock::now();
  if (!delay.waiting_since) delay.waiting_since = now;
  delay.until = now + kEarlyPoll;
}

storage::PostponedDoors DoorClosures::NotDue() {
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(delays_, [now](const auto& delay) { return delay.second.until + kForgetAfter < now; });
  std::erase_if(busy_until_, [now](const auto& site) { return site.second <= now; });
  storage::PostponedDoors postponed;
  for (const auto& [key, delay] : delays_) {
    if (delay.until > now) postponed.sessions.push_back({key.first, key.second});
  }
  for (const auto& [site, until] : busy_until_) postponed.sites.push_back(site);
  return postponed;
}

void DoorClosures::RetryLater(const storage::PendingDoors& pending, const absl::Status& status) {
  Delay& delay = delays_[KeyOf(pending)];
  delay.failures = std::min(delay.failures + 1, 8);
  delay.until = std::chrono::steady_clock::now() + std::chrono::milliseconds(250) * (1 << delay.failures);
  spdlog::warn("judging the doors of session {}: {}; will retry", pending.session.value(), status.ToString());
}

bool DoorClosures::JudgePending() {
  const auto pending = stores_.verdicts.FindPending(JudgingLease::Context(), kPendingAtOnce, NotDue());
  if (!pending.ok()) return false;  // readiness reports an unreachable database
  bool worked = false;
  for (const storage::PendingDoors& next : *pending) {
    if (stop_.is_set()) return false;
    if (busy_until_.contains(next.site)) continue;
    const auto lease = stores_.leases.Acquire(JudgingLease::Context(), next.site, owner_, JudgingLease::kTime);
    if (!lease.ok() || !*lease) {  // another process judges this site
      busy_until_[next.site] = std::chrono::steady_clock::now() + kBusyPoll;
      continue;
    }
    const absl::StatusOr<bool> settled = Settle(JudgingLease(stores_.leases, **lease, stop_), next.session);
    (void)stores_.leases.Release(JudgingLease::Context(), **lease);
    if (!settled.ok()) {
      if (!stop_.is_set()) RetryLater(next, settled.status());
    } else if (*settled) {
      delays_.erase(KeyOf(next));
      worked = true;
    } else {
      Postpone(next);
    }
  }
  return worked || pending->size() == kPendingAtOnce;  // what was tried is postponed now, and others may wait
}

absl::StatusOr<bool> DoorClosures::Settle(const JudgingLease& lease, const SessionId& id) {
  const absl::StatusOr<storage::Session> session = stores_.sessions.Get(JudgingLease::Context(), lease.site(), id);
  if (absl::IsNotFound(session.status())) {  // deleted; the sessions that follow it still need a map
    ENFILADE_RETURN_IF_ERROR(SettleWaiting(lease, id));
    return true;
  }
  ENFILADE_RETURN_IF_ERROR(session.status());
  ENFILADE_ASSIGN_OR_RETURN(const auto reports,
                            stores_.verdicts.ReadReports(JudgingLease::Context(), lease.site(), id));
  for (const storage::StoredDoorReport& report : reports) {
    if (report.judged) continue;
    ENFILADE_ASSIGN_OR_RETURN(const bool settled, SettleReport(lease, *session, report));
    if (!settled) return false;
  }
  ENFILADE_RETURN_IF_ERROR(SettleWaiting(lease, id));
  ENFILADE_RETURN_IF_ERROR(stores_.verdicts.MarkJudged(JudgingLease::Context(), lease.lease(), id));
  listeners_.judged();
  return true;
}

absl::StatusOr<bool> DoorClosures::SettleReport(const JudgingLease& lease, const storage::Session& session,
                                                const storage::StoredDoorReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  std::set<LinkPointId> redundant;
  absl::Status last;
  for (int attempt = 0; attempt < kJudgingAttempts; ++attempt) {
    ENFILADE_RETURN_IF_ERROR(lease.Renew());
    ENFILADE_ASSIGN_OR_RETURN(auto graph, graphs_.Get(JudgingLease::Context(), lease.site()));
    const double waited = SecondsWaited({lease.site(), session.id});
    ENFILADE_ASSIGN_OR_RETURN(
        const JudgedReport judged,
        JudgeReport(stores_, lease, options_, grounds_, std::move(graph),
                    {.session = session, .stored = report, .redundant = redundant, .waited = waited}));
    if (const auto* wait = std::get_if<closure::WaitForMapping>(&judged.judgement.action)) {
      spdlog::debug("door {} of session {} waits until these maps are mapped: {}", report.sequence, session.id.value(),
                    fmt::join(wait->maps, ", "));
      return false;
    }
    const absl::StatusOr<closure::DoorVerdict> verdict = ApplyDoorAction(stores_, lease, judged);
    graphs_.MarkChanged(lease.site());
    if (verdict.ok()) {
      const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
      spdlog::info("door {} of session {}: {} in {:.0f} ms: {}", report.sequence, session.id.value(),
                   closure::NameOf(verdict->decision), took.count(), verdict->reason);
      if (verdict->entered_map) listeners_.entered();
      return true;
    }
    last = verdict.status();
    const LinkPointId* changed = closure::FindChangedLinkPoint(judged.judgement.action);
    if (absl::IsAlreadyExists(last) && changed != nullptr) {
      redundant.insert(*changed);  // the database has its own definition of "the same place"
    } else if (!absl::IsAborted(last) && !absl::IsNotFound(last)) {
      return last;
    }
  }
  return last;
}

absl::Status DoorClosures::SettleWaiting(const JudgingLease& lease, const SessionId& previous) {
  ENFILADE_ASSIGN_OR_RETURN(const auto waiting,
                            stores_.verdicts.ListWaiting(JudgingLease::Context(), lease.site(), previous));
  if (waiting.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const auto passage,
                            stores_.verdicts.FindPassage(JudgingLease::Context(), lease.site(), previous));
  absl::Status entered = absl::NotFoundError("");
  if (passage) {
    entered = stores_.verdicts.Enter(JudgingLease::Context(), lease.lease(),
                                     {.previous = previous,
                                      .new_map = {},
                                      .map = *passage->entered_map,
                                      .T_map_robot = passage->T_map_robot,
                                      .T_odom_robot = passage->T_odom_robot});
  }
  if (absl::IsNotFound(entered)) {
    // No passage was reported, or its map has been deleted: a new map that no link point joins.
    const storage::NewMap map =
        ToNewMap(closure::DescribeNewMap(MapId(NewUuid()), nullptr, nullptr, options_), options_);
    entered = stores_.verdicts.Enter(
        JudgingLease::Context(), lease.lease(),
        {.previous = previous, .new_map = map, .map = map.id, .T_map_robot = {}, .T_odom_robot = {}});
    graphs_.MarkChanged(lease.site());
  }
  ENFILADE_RETURN_IF_ERROR(entered);
  spdlog::info("{} sessions after session {} have their map", waiting.size(), previous.value());
  listeners_.entered();
  return absl::OkStatus();
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/door_closures.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "server/app/closure/report_judge.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

// For a database call and for what is reckoned between two looks at the lease; judging a passage has no limit in all,
// as a slow machine would begin again and again what it never ends.
constexpr auto kJudgingTimeout = std::chrono::seconds(60);
// Other replicas' mapping does not wake this process: it looks this often.
constexpr auto kJudgingPoll = std::chrono::milliseconds(500);
constexpr auto kBusyPoll = std::chrono::milliseconds(50);
constexpr auto kEarlyPoll = std::chrono::seconds(2);
constexpr auto kJudgingLeaseTime = std::chrono::seconds(20);
constexpr int kPendingAtOnce = 32;
// The graph changes while a report is judged: people edit, other sites' replicas do not.
constexpr int kJudgingAttempts = 10;

storage::CallContext JudgingContext() {
  storage::CallContext context = storage::CallContext::WithTimeout(kJudgingTimeout);
  context.actor = "closure at a door";
  return context;
}

const char* InWords(closure::DoorDecision decision) {
  switch (decision) {
    case closure::DoorDecision::kCandidateMade:
      return "a candidate";
    case closure::DoorDecision::kCandidateKnown:
      return "known";
    case closure::DoorDecision::kCandidatePromoted:
      return "a candidate promoted";
    case closure::DoorDecision::kLinkPointRecognised:
      return "a link point recognised";
    case closure::DoorDecision::kLinkPointMade:
      return "a new link point";
    case closure::DoorDecision::kNotJudged:
      return "not judged";
  }
  return "?";
}

std::string NameOf(const storage::PendingDoors& pending) {
  return pending.site.value() + "/" + pending.session.value();
}

}  // namespace

DoorClosures::DoorClosures(const closure::DoorClosureOptions& options, const DoorClosureStores& stores,
                           SiteGraphs& graphs, WakeSignal& wake, std::function<void()> entered)
    : options_(options),
      stores_(stores),
      graphs_(graphs),
      wake_(wake),
      entered_(std::move(entered)),
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
    site_busy_ = false;
    if (!TakeTurn()) wake_.WaitFor(site_busy_ ? kBusyPoll : kJudgingPoll);
  }
}

double DoorClosures::WaitedFor(const storage::PendingDoors& pending) const {
  const auto found = delays_.find(NameOf(pending));
  if (found == delays_.end() || !found->second.early_since) return 0.0;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - *found->second.early_since).count();
}

void DoorClosures::Postpone(const storage::PendingDoors& pending) {
  Delay& delay = delays_[NameOf(pending)];
  const auto now = std::chrono::steady_clock::now();
  if (!delay.early_since) delay.early_since = now;
  delay.until = now + kEarlyPoll;
}

bool DoorClosures::MayTry(const storage::PendingDoors& pending) {
  const auto found = delays_.find(NameOf(pending));
  return found == delays_.end() || found->second.until <= std::chrono::steady_clock::now();
}

void DoorClosures::Failed(const storage::PendingDoors& pending, const absl::Status& status) {
  Delay& delay = delays_[NameOf(pending)];
  delay.failures = std::min(delay.failures + 1, 8);
  delay.until = std::chrono::steady_clock::now() + std::chrono::milliseconds(250) * (1 << delay.failures);
  spdlog::warn("doors of session {}: {}; again later", pending.session.value(), status.ToString());
}

bool DoorClosures::TakeTurn() {
  const auto pending = stores_.verdicts.FindPending(JudgingContext(), kPendingAtOnce);
  if (!pending.ok()) return false;  // readiness tells of an unreachable database
  bool worked = false;
  for (const storage::PendingDoors& next : *pending) {
    if (stop_.is_set()) return false;
    if (!MayTry(next)) continue;
    const auto lease = stores_.leases.Acquire(JudgingContext(), next.site, owner_, kJudgingLeaseTime);
    if (!lease.ok() || !*lease) {  // another one is at this site
      site_busy_ = true;
      continue;
    }
    const absl::StatusOr<bool> settled = Settle(**lease, next.session);
    (void)stores_.leases.Release(JudgingContext(), **lease);
    if (!settled.ok()) {
      if (!stop_.is_set()) Failed(next, settled.status());
    } else if (*settled) {
      delays_.erase(NameOf(next));
      worked = true;
    } else {
      Postpone(next);
    }
  }
  return worked;
}

absl::StatusOr<bool> DoorClosures::Settle(const storage::SiteLease& lease, const SessionId& id) {
  const absl::StatusOr<storage::Session> session = stores_.sessions.Get(JudgingContext(), lease.site, id);
  if (absl::IsNotFound(session.status())) {  // deleted: those that came out of it still need a map
    ENFILADE_RETURN_IF_ERROR(SettleWaiting(lease, id));
    return true;
  }
  ENFILADE_RETURN_IF_ERROR(session.status());
  ENFILADE_ASSIGN_OR_RETURN(const auto reports, stores_.verdicts.ReadReports(JudgingContext(), lease.site, id));
  for (const storage::StoredDoorReport& report : reports) {
    if (report.judged) continue;
    ENFILADE_ASSIGN_OR_RETURN(const bool settled, SettleReport(lease, *session, report));
    if (!settled) return false;
  }
  ENFILADE_RETURN_IF_ERROR(SettleWaiting(lease, id));
  ENFILADE_RETURN_IF_ERROR(stores_.verdicts.MarkJudged(JudgingContext(), lease, id));
  return true;
}

absl::StatusOr<bool> DoorClosures::SettleReport(const storage::SiteLease& lease, const storage::Session& session,
                                                const storage::StoredDoorReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  storage::CallContext context = JudgingContext();
  const auto go_on = [&]() -> absl::Status {
    if (stop_.is_set()) return absl::CancelledError("the server is about to end");
    context = JudgingContext();
    return stores_.leases.Renew(context, lease, kJudgingLeaseTime);
  };
  std::set<LinkPointId> redundant;
  absl::Status last;
  for (int attempt = 0; attempt < kJudgingAttempts; ++attempt) {
    ENFILADE_RETURN_IF_ERROR(go_on());
    ENFILADE_ASSIGN_OR_RETURN(const auto graph, graphs_.Get(JudgingContext(), lease.site));
    const ReportJudge judge(stores_, options_, graph, go_on);
    ENFILADE_ASSIGN_OR_RETURN(
        const ReportJudge::Judgement judgement,
        judge.Judge(context, session, report, redundant, WaitedFor(storage::PendingDoors{lease.site, session.id})));
    if (!judgement.wait_for.empty()) {
      spdlog::debug("door {} of session {} waits for what is being mapped of{}", report.sequence, session.id.value(),
                    judgement.wait_for);
      return false;
    }
    const storage::DoorChange& change = judgement.change;
    last = stores_.verdicts.Commit(JudgingContext(), lease, change);
    graphs_.MarkChanged(lease.site);
    if (last.ok()) {
      const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
      spdlog::info("door {} of session {}: {} in {:.0f} ms: {}", report.sequence, session.id.value(),
                   InWords(change.verdict.decision), took.count(), change.verdict.reason);
      if (change.verdict.entered_map) entered_();
      return true;
    }
    if (absl::IsAlreadyExists(last) && change.link_point) {
      redundant.insert(change.link_point->point.id);  // the database draws the line of "the same place" itself
    } else if (!absl::IsAborted(last) && !absl::IsNotFound(last)) {
      return last;
    }
  }
  return last;
}

absl::Status DoorClosures::SettleWaiting(const storage::SiteLease& lease, const SessionId& previous) {
  ENFILADE_ASSIGN_OR_RETURN(const auto waiting, stores_.verdicts.ListWaiting(JudgingContext(), lease.site, previous));
  if (waiting.empty()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const auto passage, stores_.verdicts.FindPassage(JudgingContext(), lease.site, previous));
  absl::Status entered = absl::NotFoundError("");
  if (passage) {
    entered = stores_.verdicts.Enter(JudgingContext(), lease,
                                     {.previous = previous,
                                      .new_map = {},
                                      .map = *passage->entered_map,
                                      .T_map_robot = passage->T_map_robot,
                                      .T_odom_robot = passage->T_odom_robot});
  }
  if (absl::IsNotFound(entered)) {
    // No passage was reported, or its map has been deleted: a new one that nothing joins.
    const storage::NewMap map = MapBehind(std::nullopt, nullptr, options_);
    entered = stores_.verdicts.Enter(
        JudgingContext(), lease,
        {.previous = previous, .new_map = map, .map = map.id, .T_map_robot = {}, .T_odom_robot = {}});
    graphs_.MarkChanged(lease.site);
  }
  ENFILADE_RETURN_IF_ERROR(entered);
  spdlog::info("{} sessions out of session {} have their map", waiting.size(), previous.value());
  entered_();
  return absl::OkStatus();
}

}  // namespace enfilade::server

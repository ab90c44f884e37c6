// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/mapping.h"

#include <unistd.h>

#include <chrono>
#include <exception>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "server/app/runtime/thread_priority.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr auto kWorkTimeout = std::chrono::seconds(30);
constexpr auto kStopTimeout = std::chrono::seconds(2);
constexpr auto kTurn = std::chrono::seconds(3);
// The shortest time between two looks for work of one worker, so that records of a live robot are mapped in batches,
// and many robots do not cost many looks.
constexpr auto kMinTurnInterval = std::chrono::milliseconds(100);
// Records that other processes store do not wake this one: it polls for them.
constexpr auto kPollInterval = std::chrono::seconds(1);

std::chrono::milliseconds LeaseTime(const ServerOptions::Mapping& options) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(options.lease_s * 1000.0));
}

SessionMappingOptions SessionOptions(const ServerOptions::Mapping& options, const slam::SlamProfiles& slam) {
  SessionMappingOptions session;
  session.pairing.window_s = options.pairing_window_s;
  session.slam = slam;
  session.checkpoint_interval = std::chrono::duration<double>(options.checkpoint_interval_s);
  session.revision_interval = std::chrono::duration<double>(options.revision_interval_s);
  return session;
}

// Whether trying again would not help.
bool IsFinal(const absl::Status& status, std::int64_t attempts) {
  if (absl::IsInternal(status)) return attempts >= Mapping::kMaxAttempts;
  return absl::IsDataLoss(status) || absl::IsFailedPrecondition(status);
}

}  // namespace

struct Mapping::Turn {
  storage::SessionLease lease;
  std::atomic<bool> lease_lost{false};
};

Mapping::Mapping(const ServerOptions::Mapping& options, const slam::SlamProfiles& slam,
                 const SessionMappingStores& stores, Metrics& metrics, std::function<void()> on_session_ended)
    : options_(options),
      stores_(stores),
      session_options_(SessionOptions(options, slam)),
      metrics_(metrics),
      on_session_ended_(std::move(on_session_ended)),
      owner_(NewUuid()),
      parked_(static_cast<std::size_t>(options.parked_bytes)) {
  for (int i = 0; i < options.workers; ++i) workers_.emplace_back([this, i] { Work(i); });
  lease_keeper_ = std::thread([this] { KeepLeases(); });
}

Mapping::~Mapping() {
  Stop();
  for (std::thread& worker : workers_) worker.join();
  Queue(storage::CallContext::WithTimeout(kStopTimeout),  // for all of them; the next server stores them
        parked_.ListUnstored([](const SessionMapping&) { return true; }));
  workers_done_.Set();
  lease_keeper_.join();
}

void Mapping::Wake(const SiteId& site, const SessionId& session) {
  {
    MutexLock lock(mutex_);
    for (const auto& turn : turns_) {
      if (turn->lease.site == site && turn->lease.session == session) return;
    }
    if (!woken_.emplace(site, session).second) return;
  }
  wake_.Wake();
}

void Mapping::Wake() { wake_.Wake(); }

void Mapping::Stop() {
  stop_.Set();
  Wake();
}

void Mapping::Work(int worker) {
  SetThreadNiceness(kBackgroundNiceness);  // calls, streams and the database come first
  const std::string owner = fmt::format("{}/{}", owner_, worker);
  while (!stop_.is_set()) {
    const auto begin = std::chrono::steady_clock::now();
    // Of robots that send nothing more.
    Queue(storage::CallContext::WithTimeout(kWorkTimeout),
          parked_.ListUnstored([](const SessionMapping& mapping) { return mapping.overdue(); }));
    if (!TakeTurn(owner)) wake_.WaitFor(kPollInterval);
    stop_.WaitFor(kMinTurnInterval - (std::chrono::steady_clock::now() - begin));
  }
}

bool Mapping::TakeTurn(const std::string& owner) {
  std::size_t woken = 0;
  {
    MutexLock lock(mutex_);
    woken = woken_.size();
    woken_.clear();
  }
  const auto leased =
      stores_.mappings.Acquire(storage::CallContext::WithTimeout(kWorkTimeout), owner, LeaseTime(options_));
  if (!leased.ok() || !*leased) return false;  // Readiness reports an unreachable database
  const auto turn = std::make_shared<Turn>();
  turn->lease = (*leased)->lease;
  {
    MutexLock lock(mutex_);
    turns_.push_back(turn);
  }
  if (woken > 1) wake_.Wake();  // another worker, for the other sessions
  metrics_.AddSessionsMapping(1);
  MapSession(**leased, *turn);
  metrics_.AddSessionsMapping(-1);
  {
    MutexLock lock(mutex_);
    turns_.remove(turn);
  }
  return true;
}

void Mapping::MapSession(const storage::LeasedSession& leased, Turn& turn) {
  const std::string& session = leased.session.id.value();
  std::unique_ptr<SessionMapping> mapping;
  absl::Status status = MapForOneTurn(leased, turn, mapping);
  const bool failed = IsFinal(status, leased.attempts);
  const bool ended = failed || (mapping && mapping->ended());
  const std::int64_t read_sequence = mapping ? mapping->read_sequence() : 0;
  if (status.ok()) {
    if (!ended) {
      Queue(storage::CallContext::WithTimeout(kWorkTimeout), parked_.Park(leased.lease, std::move(mapping)));
    }
  } else if (failed) {
    mapping.reset();
    spdlog::error("mapping: session {} failed: {}", session, status.ToString());
    status = SessionMapping::Fail(stores_, leased, status);
  } else {
    spdlog::warn("mapping: session {} will be resumed from its checkpoint: {}", session, status.ToString());
    // The lease is left to run out: the attempt stays counted, and the next one comes later.
    if (absl::IsInternal(status)) return;
  }
  // If the database is unreachable, the lease expires.
  (void)stores_.mappings.Release(storage::CallContext::WithTimeout(kWorkTimeout), leased.lease, read_sequence);
  if (ended && on_session_ended_) on_session_ended_();
}

// INTERNAL after an exception.
absl::Status Mapping::MapForOneTurn(const storage::LeasedSession& leased, Turn& turn,
                                    std::unique_ptr<SessionMapping>& mapping) {
  if (leased.attempts > kMaxAttempts) {
    return Internal("{} attempts to map the session ended before their time; memory may not suffice for it",
                    leased.attempts - 1);
  }
  try {
    mapping = parked_.Take(leased);
    const bool was_parked = mapping != nullptr;
    if (!mapping) {
      ENFILADE_ASSIGN_OR_RETURN(mapping, SessionMapping::Load(stores_, session_options_, leased.session));
    }
    return MapUntilTurnEnds(leased, *mapping, turn, was_parked);
  } catch (const std::exception& exception) {
    mapping.reset();
    return Internal("attempt {} to map the session: {}", leased.attempts, exception.what());
  }
}

absl::Status Mapping::MapUntilTurnEnds(const storage::LeasedSession& leased, SessionMapping& mapping, Turn& turn,
                                       bool was_parked) {
  const storage::SessionLease& lease = leased.lease;
  // Its turn ends with what was stored when it began. Looking for more takes two calls of the database, and the next
  // turn finds it anyway.
  const bool is_live = leased.session.state == storage::SessionState::kRecording;
  const auto end = std::chrono::steady_clock::now() + kTurn;
  while (!turn.lease_lost && !stop_.is_set() && std::chrono::steady_clock::now() < end) {
    const slam::LogMapperCounts before = mapping.counts();
    ENFILADE_ASSIGN_OR_RETURN(const SessionMapping::Progress progress, mapping.Step(lease));
    const slam::LogMapperCounts after = mapping.counts();
    const std::int64_t used = after.used - before.used;
    const std::int64_t settled =
        after.pairing.paired + after.pairing.unpaired - before.pairing.paired - before.pairing.unpaired;
    metrics_.CountScansMapped(used, settled - used);
    if (progress == SessionMapping::Progress::kEnded) return absl::OkStatus();
    if (progress == SessionMapping::Progress::kWaiting) break;
    if (is_live && mapping.read_sequence() >= lease.acknowledged_sequence) break;
  }
  if (turn.lease_lost) return absl::AbortedError("the lease is lost");
  return was_parked && !stop_.is_set() ? mapping.StoreIfDue(lease) : mapping.Store(lease);
}

void Mapping::Queue(const storage::CallContext& context, const std::vector<storage::SessionLease>& leases) const {
  for (const storage::SessionLease& lease : leases) {
    const absl::Status queued = stores_.mappings.Queue(context, lease.site, lease.session);
    if (queued.ok()) continue;
    spdlog::warn("mapping: what was mapped last of session {} is stored only with its next records: {}",
                 lease.session.value(), queued.ToString());
  }
}

void Mapping::KeepLeases() {
  const auto interval = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(options_.lease_s / 3.0));
  while (!workers_done_.WaitFor(interval)) {
    RenewLeases();
    ReportBacklog();
  }
}

void Mapping::RenewLeases() {
  std::list<std::shared_ptr<Turn>> turns;
  {
    MutexLock lock(mutex_);
    turns = turns_;
  }
  for (const auto& turn : turns) {
    const absl::Status status = stores_.mappings.Renew(storage::CallContext::WithTimeout(LeaseTime(options_) / 3),
                                                       turn->lease, LeaseTime(options_));
    if (absl::IsAborted(status)) turn->lease_lost = true;
  }
}

// While the database is unreachable, the metric stays as it was.
void Mapping::ReportBacklog() {
  const auto backlog = stores_.mappings.GetBacklog(storage::CallContext::WithTimeout(LeaseTime(options_) / 3));
  if (backlog.ok()) metrics_.SetMappingBacklog(*backlog);
}

}  // namespace enfilade::server

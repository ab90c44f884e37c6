// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_optimizer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/graph/solve/extend_solution.h"
#include "server/app/graph/held_site_lease.h"
#include "server/app/runtime/thread_priority.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

// Attempts without locking the graph.
constexpr int kOptimisticAttempts = 3;
// Changes come in bursts: a closure changes a link point and its evidence, and often causes the next closure.
constexpr auto kSettleTime = std::chrono::milliseconds(300);
constexpr int kWorkers = 2;
// A large graph keeps a processor busy for seconds, and calls must not feel it.
constexpr auto kSolveTimeout = std::chrono::seconds(60);
// Then another process may solve the same graph, which does no harm.
constexpr auto kSolveLeaseTime = std::chrono::seconds(30);
constexpr auto kStoreLeaseTime = std::chrono::seconds(30);
// How long a worker waits while doors are judged. Then other sites have their turn.
constexpr auto kStoreTimeout = std::chrono::seconds(2);
// Solutions that differ by less are equal, m and rad.
constexpr double kPoseTolerance = 1e-6;

// ": a, b, ...": as many as fit into a line.
std::string FirstNames(const std::vector<graph::SwitchedOff>& switched_off) {
  constexpr std::size_t kNames = 10;
  std::string names;
  for (std::size_t i = 0; i < switched_off.size() && i <= kNames; ++i) {
    names += i == 0 ? ": " : ", ";
    names += i == kNames ? "..." : switched_off[i].link_point.value();
  }
  return names;
}

bool HasContradictedPlan(const graph::SolvedGraph& solution) {
  return std::any_of(solution.plans.begin(), solution.plans.end(),
                     [](const graph::PlanUse& plan) { return !plan.contradiction.empty(); });
}

bool IsSame(const graph::GraphSnapshot& graph, const graph::SolvedGraph& solution) {
  if (HasContradictedPlan(solution)) return false;
  // A solution that only places the root adds nothing.
  if (graph.solution() == nullptr) return solution.map_poses.size() <= 1 && solution.switched_off.empty();
  if (graph.solution()->map_poses.size() != solution.map_poses.size()) return false;
  for (const auto& [map, pose] : solution.map_poses) {
    const auto found = graph.solution()->map_poses.find(map);
    if (found == graph.solution()->map_poses.end()) return false;
    const Pose2 d = Between(found->second.pose, pose.pose);
    if (d.translation().norm() > kPoseTolerance || std::abs(d.yaw) > kPoseTolerance) return false;
    if (!found->second.covariance.isApprox(pose.covariance, 1e-6) && !pose.covariance.isZero()) return false;
  }
  return graph::ChangesOf(graph, solution, 0).link_points.empty();
}

// Includes the link points' places that follow from the new map poses.
absl::StatusOr<storage::GraphSolution> StoredSolution(const SiteGraph& graph, const graph::SolvedGraph& solution) {
  const graph::GraphSnapshot& unsolved = graph.graph();
  ENFILADE_ASSIGN_OR_RETURN(graph::GraphSnapshot solved,
                            graph::Apply(unsolved, graph::ChangesOf(unsolved, solution, unsolved.version() + 1)));
  return ToStored(graph, graph::WorldPoses(std::move(solved)), solution);
}

}  // namespace

GraphOptimizer::GraphOptimizer(const storage::GraphStore& store, const Leases& leases, SiteGraphs& graphs,
                               ChangedSites& changed, std::chrono::milliseconds longest_locked_solve)
    : store_(store),
      leases_(leases),
      graphs_(graphs),
      changed_(changed),
      longest_locked_solve_(longest_locked_solve),
      owner_(NewUuid() + "/graph") {
  for (int i = 0; i < kWorkers; ++i) workers_.emplace_back([this] { Run(); });
}

GraphOptimizer::~GraphOptimizer() {
  Stop();
  for (std::thread& worker : workers_) worker.join();
}

void GraphOptimizer::Stop() { stop_.Set(); }

absl::StatusOr<OptimizedGraph> GraphOptimizer::Optimize(const storage::CallContext& context, const SiteId& site) {
  ENFILADE_ASSIGN_OR_RETURN(const HeldSiteLease lease,
                            HeldSiteLease::Await(leases_.solve, context, site, owner_, kSolveLeaseTime, &stop_));
  return SolveAndStore(context, site, {});
}

absl::StatusOr<std::shared_ptr<const graph::SolvedGraph>> GraphOptimizer::Solve(const SiteId& site,
                                                                                const graph::GraphSnapshot& graph) {
  const Solved last = LastSolved(site);
  std::optional<graph::SolvedGraph> solution;
  if (last.graph != nullptr) solution = graph::ExtendSolution(last.graph->graph(), *last.solution, graph);
  if (!solution) {
    ENFILADE_ASSIGN_OR_RETURN(solution, graph::OptimizeGraph(graph));
  }
  return std::make_shared<const graph::SolvedGraph>(*std::move(solution));
}

absl::StatusOr<OptimizedGraph> GraphOptimizer::SolveAndStore(const storage::CallContext& context, const SiteId& site,
                                                             Solved last) {
  std::chrono::steady_clock::duration solving{0};  // the last time
  for (int attempt = 0; attempt < kOptimisticAttempts; ++attempt) {
    ENFILADE_ASSIGN_OR_RETURN(const std::shared_ptr<const SiteGraph> graph, graphs_.Get(context, site));
    std::optional<graph::SolvedGraph> solution;
    if (last.graph != nullptr) solution = graph::ExtendSolution(last.graph->graph(), *last.solution, graph->graph());
    if (!solution) {
      const auto begin = std::chrono::steady_clock::now();
      ENFILADE_ASSIGN_OR_RETURN(solution, graph::OptimizeGraph(graph->graph()));
      solving = std::chrono::steady_clock::now() - begin;
    }
    bool is_outdated = false;
    const absl::StatusOr<std::int64_t> version = Store(context, site, *graph, *solution, is_outdated);
    if (version.ok()) {
      Remember(site, graph, *solution);
      return OptimizedGraph{*version, *std::move(solution)};
    }
    if (!is_outdated) return version.status();
    last = {graph, std::make_shared<const graph::SolvedGraph>(*std::move(solution))};
  }
  if (solving > longest_locked_solve_) {
    return Aborted("the graph of site {} changes faster than it can be solved, which takes {:.1f} s: try again",
                   site.value(), std::chrono::duration<double>(solving).count());
  }
  return SolveLocked(context, site);
}

absl::StatusOr<OptimizedGraph> GraphOptimizer::SolveLocked(const storage::CallContext& context, const SiteId& site) {
  ENFILADE_ASSIGN_OR_RETURN(const std::shared_ptr<const SiteGraph> known, graphs_.Get(context, site));
  OptimizedGraph optimized;
  const auto solve = [&](const storage::GraphChanges& changes) -> absl::StatusOr<storage::GraphSolution> {
    const SiteGraph none{graph::GraphSnapshot()};
    const SiteGraph& before = changes.complete ? none : *known;
    graph::SnapshotChanges snapshot_changes = ToSnapshotChanges(changes);
    snapshot_changes.plans = known->graph().plans();
    ENFILADE_ASSIGN_OR_RETURN(graph::GraphSnapshot snapshot, graph::Apply(before.graph(), snapshot_changes));
    PlacedLinkPoints placed = before.placed.With(before.graph(), snapshot, changes);
    SiteGraph graph(std::move(snapshot), std::move(placed));
    ENFILADE_ASSIGN_OR_RETURN(optimized.solution, graph::OptimizeGraph(graph.graph()));
    return StoredSolution(graph, optimized.solution);  // complete: others may have optimised since
  };
  ENFILADE_ASSIGN_OR_RETURN(optimized.version, store_.SolveHeld(context, site, known->graph().version(), solve));
  graphs_.MarkChanged(site);
  return optimized;
}

void GraphOptimizer::Run() {
  SetThreadNiceness(kBackgroundNiceness);
  while (!stop_.WaitFor(kSettleTime)) {
    {
      MutexLock lock(mutex_);
      waiting_.merge(changed_.Take());
    }
    while (const std::optional<SiteId> site = TakeWaiting()) {
      if (stop_.is_set()) return;
      TryToOptimize(*site);
      MutexLock lock(mutex_);
      taken_.erase(*site);
    }
  }
}

std::optional<SiteId> GraphOptimizer::TakeWaiting() {
  MutexLock lock(mutex_);
  for (auto site = waiting_.begin(); site != waiting_.end(); ++site) {
    if (!taken_.insert(*site).second) continue;  // its next turn comes after this one
    return std::move(waiting_.extract(site).value());
  }
  return std::nullopt;
}

void GraphOptimizer::TryToOptimize(const SiteId& site) {
  {
    MutexLock lock(mutex_);
    if (!backoff_.IsDue(site, std::chrono::steady_clock::now())) return changed_.Add(site);
  }
  const absl::Status status = OptimizeIfDue(site);
  if (absl::IsAborted(status)) return changed_.Add(site);
  MutexLock lock(mutex_);
  if (status.ok() || absl::IsNotFound(status)) return backoff_.Succeed(site);
  const std::chrono::seconds wait = backoff_.Fail(site, std::chrono::steady_clock::now());
  changed_.Add(site);
  spdlog::warn("cannot optimise the graph of {}; next attempt in {} s: {}", site.value(), wait.count(),
               status.ToString());
}

GraphOptimizer::Solved GraphOptimizer::LastSolved(const SiteId& site) {
  MutexLock lock(mutex_);
  const auto found = solved_.find(site);
  return found == solved_.end() ? Solved{} : found->second;
}

void GraphOptimizer::Remember(const SiteId& site, std::shared_ptr<const SiteGraph> graph, graph::SolvedGraph solution) {
  MutexLock lock(mutex_);
  solved_[site] = {std::move(graph), std::make_shared<const graph::SolvedGraph>(std::move(solution))};
}

absl::Status GraphOptimizer::OptimizeIfDue(const SiteId& site) {
  const storage::CallContext context = storage::CallContext::WithTimeout(kSolveTimeout);
  const auto graph = graphs_.Get(context, site);
  if (absl::IsNotFound(graph.status())) {
    MutexLock lock(mutex_);
    solved_.erase(site);
    unstored_.erase(site);
  }
  ENFILADE_RETURN_IF_ERROR(graph.status());
  if ((*graph)->graph().root().empty()) return absl::OkStatus();
  const Solved last = LastSolved(site);
  std::optional<graph::SolvedGraph> solution;
  if (last.graph != nullptr) solution = graph::ExtendSolution(last.graph->graph(), *last.solution, (*graph)->graph());
  if (solution && solution->map_poses.size() == last.solution->map_poses.size()) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const auto lease, leases_.solve.Acquire(context, site, owner_, kSolveLeaseTime));
  if (!lease) return Aborted("another process is solving the graph of site {}", site.value());
  const absl::Status optimized = SolveIfChanged(site, *graph, std::move(solution));
  (void)leases_.solve.Release(storage::CallContext::WithTimeout(kStoreTimeout), *lease);
  return optimized;
}

absl::Status GraphOptimizer::SolveIfChanged(const SiteId& site, const std::shared_ptr<const SiteGraph>& graph,
                                            std::optional<graph::SolvedGraph> solution) {
  if (!solution) solution = TakeUnstored(site, *graph);
  if (!solution) {
    ENFILADE_ASSIGN_OR_RETURN(solution, graph::OptimizeGraph(graph->graph()));
  }
  if (!IsSame(graph->graph(), *solution)) {
    bool is_outdated = false;
    const absl::StatusOr<std::int64_t> version =
        Store(storage::CallContext::WithTimeout(kStoreTimeout), site, *graph, *solution, is_outdated);
    if (absl::IsAborted(version.status())) {
      const Solved found{graph, std::make_shared<const graph::SolvedGraph>(*std::move(solution))};
      if (is_outdated) return SolveAndStore(storage::CallContext::WithTimeout(kSolveTimeout), site, found).status();
      MutexLock lock(mutex_);
      unstored_[site] = found;
    }
    ENFILADE_RETURN_IF_ERROR(version.status());
    spdlog::info("graph of {}: version {}: {} maps, chi-squared {:.1f} to {:.1f}, {} link points switched off{}",
                 site.value(), *version, solution->map_poses.size(), solution->chi2_before, solution->chi2_after,
                 solution->switched_off.size(), FirstNames(solution->switched_off));
    for (const graph::PlanUse& plan : solution->plans) {
      spdlog::info("{}: {} walls that maps have seen count, {} do not{}{}", NameOf(site, plan.plan), plan.used,
                   plan.switched_off, plan.contradiction.empty() ? "" : ": it diverges: ", plan.contradiction);
    }
  }
  Remember(site, graph, *std::move(solution));
  return absl::OkStatus();
}

absl::StatusOr<std::int64_t> GraphOptimizer::Store(const storage::CallContext& context, const SiteId& site,
                                                   const SiteGraph& graph, const graph::SolvedGraph& solution,
                                                   bool& is_outdated) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::GraphSolution stored, StoredSolution(graph, solution));
  ENFILADE_ASSIGN_OR_RETURN(const HeldSiteLease lease,
                            HeldSiteLease::Await(leases_.change, context, site, owner_, kStoreLeaseTime, &stop_));
  absl::StatusOr<std::int64_t> version = store_.Apply(context, site, graph.graph().version(), stored);
  is_outdated = absl::IsAborted(version.status());
  graphs_.MarkChanged(site);
  return version;
}

std::optional<graph::SolvedGraph> GraphOptimizer::TakeUnstored(const SiteId& site, const SiteGraph& graph) {
  MutexLock lock(mutex_);
  const auto found = unstored_.extract(site);
  if (found.empty() || found.mapped().graph->graph().version() != graph.graph().version()) return std::nullopt;
  return *found.mapped().solution;
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "core/localization/localize.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/localization/pose_tracking.h"
#include "core/slam/loops/edge_information.h"
#include "fmt/format.h"

namespace enfilade::localization {
namespace {

struct Hypothesis {
  std::size_t map = 0;
  TrackedPose tracked;
};

// A place in a map where one scan fits.
struct Seed {
  std::size_t map = 0;
  std::size_t scan = 0;
  FoundPose found;
};

class Localizer {
 public:
  Localizer(std::vector<TrackedScan> scans, const std::vector<CandidateMap>& maps, const LocalizationOptions& options,
            const KeepGoing& keep_going)
      : scans_(std::move(scans)),
        searched_(ScansToSearch(scans_, options)),
        maps_(maps),
        options_(options),
        keep_going_(keep_going) {}

  absl::StatusOr<Localization> Run() {
    for (std::size_t map = 0; map < maps_.size(); ++map) ENFILADE_RETURN_IF_ERROR(FindSeeds(map));
    DropWeakSeeds();
    for (const std::size_t map : MapsByScore()) ENFILADE_RETURN_IF_ERROR(FollowSeeds(map));
    std::stable_sort(hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& a, const Hypothesis& b) {
      return a.tracked.log_likelihood > b.tracked.log_likelihood;
    });
    return Judge();
  }

 private:
  absl::Status FindSeeds(std::size_t map) {
    ENFILADE_ASSIGN_OR_RETURN(const auto loaded, maps_[map].load());
    for (const std::size_t scan : searched_) {
      ENFILADE_ASSIGN_OR_RETURN(const FoundPoses found, FindPoses(*loaded, scans_[scan].points.searched,
                                                                  AreaOf(maps_[map], scan), options_, keep_going_));
      if (!found.complete) incomplete_.insert(scan);
      for (const FoundPose& one : found.poses) seeds_.push_back({map, scan, one});
    }
    return absl::OkStatus();
  }

  // Those that are weak beside the best of their scan in all maps.
  void DropWeakSeeds() {
    std::vector<double> best(scans_.size(), 0.0);
    for (const Seed& seed : seeds_) best[seed.scan] = std::max(best[seed.scan], seed.found.score);
    std::erase_if(seeds_,
                  [&](const Seed& seed) { return seed.found.score < options_.min_relative_score * best[seed.scan]; });
    std::stable_sort(seeds_.begin(), seeds_.end(),
                     [](const Seed& a, const Seed& b) { return a.found.score > b.found.score; });
  }

  // Those with seeds, the one with the best seed first.
  std::vector<std::size_t> MapsByScore() const {
    std::vector<std::size_t> maps;
    for (const Seed& seed : seeds_) {
      if (std::find(maps.begin(), maps.end(), seed.map) == maps.end()) maps.push_back(seed.map);
    }
    return maps;
  }

  absl::Status FollowSeeds(std::size_t map) {
    ENFILADE_ASSIGN_OR_RETURN(const auto loaded, maps_[map].load());
    for (const Seed& seed : seeds_) {
      if (seed.map == map) ENFILADE_RETURN_IF_ERROR(Follow(*loaded, seed));
    }
    return absl::OkStatus();
  }

  std::optional<SearchArea> AreaOf(const CandidateMap& map, std::size_t scan) const {
    if (!map.T_map_robot) return std::nullopt;
    const double driven = Between(scans_.back().T_odom_robot, scans_[scan].T_odom_robot).translation().norm();
    return SearchArea{map.T_map_robot->pose.translation(), PriorRadius(*map.T_map_robot) + driven};
  }
  double PriorRadius(const PoseWithCovariance& prior) const {
    return options_.prior_sigmas * std::sqrt(std::max(prior.covariance(0, 0) + prior.covariance(1, 1), 0.0)) +
           options_.prior_distance;
  }
  bool AgreesWithPrior(std::size_t map, const Pose2& pose) const {
    const std::optional<PoseWithCovariance>& prior = maps_[map].T_map_robot;
    if (!prior) return true;
    const Pose2 off = Between(prior->pose, pose);
    const double yaw_sigma = std::sqrt(std::max(prior->covariance(2, 2), 0.0));
    return off.translation().norm() <= PriorRadius(*prior) &&
           std::abs(off.yaw) <= options_.prior_sigmas * yaw_sigma + options_.prior_angle;
  }

  bool IsSame(const Pose2& a, const Pose2& b, double closeness) const {
    const Pose2 off = Between(a, b);
    return off.translation().norm() < closeness * options_.same_distance &&
           std::abs(off.yaw) < closeness * options_.same_angle;
  }

  absl::Status Follow(const SearchableMap& map, const Seed& seed) {
    ENFILADE_RETURN_IF_ERROR(keep_going_());
    const Pose2 predicted =
        seed.found.T_map_robot * Between(scans_[seed.scan].T_odom_robot, scans_.back().T_odom_robot);
    if (!AgreesWithPrior(seed.map, predicted)) return absl::OkStatus();
    const std::optional<TrackedPose> tracked =
        TrackPose(map, scans_, seed.scan, seed.found.T_map_robot, best_likelihood_ - options_.listed_odds, options_);
    if (!tracked || !AgreesWithPrior(seed.map, tracked->T_map_robot.pose)) return absl::OkStatus();
    best_likelihood_ = std::max(best_likelihood_, tracked->log_likelihood);
    for (Hypothesis& known : hypotheses_) {
      if (known.map != seed.map || !IsSame(known.tracked.T_map_robot.pose, tracked->T_map_robot.pose, 1.0)) continue;
      if (tracked->log_likelihood > known.tracked.log_likelihood) known.tracked = *tracked;
      return absl::OkStatus();
    }
    hypotheses_.push_back({seed.map, *tracked});
    return absl::OkStatus();
  }

  // The same place, also in two maps that overlap.
  bool IsSamePlace(const Hypothesis& a, const Hypothesis& b) const {
    if (a.map == b.map) return IsSame(a.tracked.T_map_robot.pose, b.tracked.T_map_robot.pose, 1.0);
    const auto& T_world_a = maps_[a.map].T_world_map;
    const auto& T_world_b = maps_[b.map].T_world_map;
    return T_world_a && T_world_b &&
           IsSame(*T_world_a * a.tracked.T_map_robot.pose, *T_world_b * b.tracked.T_map_robot.pose, 2.0);
  }

  bool IsKnown(const ScanEvidence& seen) const {
    return seen.matched >= options_.min_matched && seen.matched >= options_.min_agreement * seen.known();
  }

  Localization Judge() const {
    Localization result;
    if (hypotheses_.empty() || !IsKnown(hypotheses_.front().tracked.evidence)) {
      result.reason = hypotheses_.empty()
                          ? "no place in the maps fits the scans"
                          : fmt::format("nowhere known: at the best place only {:.0f} % of the hits lie on walls",
                                        100.0 * hypotheses_.front().tracked.evidence.matched);
      return result;
    }
    const double best = hypotheses_.front().tracked.log_likelihood;
    for (const Hypothesis& one : hypotheses_) {
      if (best - one.tracked.log_likelihood > options_.listed_odds) break;
      result.poses.push_back(
          {one.map, one.tracked.T_map_robot, one.tracked.evidence.matched, best - one.tracked.log_likelihood, false});
    }
    const std::string doubt = FindDoubt();
    result.poses.front().confident = doubt.empty();
    result.reason = doubt.empty() ? Certainty() : "not certain: " + doubt;
    return result;
  }

  // A place that is less likely only because less of it is known: the robot may be there, in a part that nobody has
  // seen and that looks like the best place.
  const Hypothesis* FindHalfKnown() const {
    const Hypothesis& best = hypotheses_.front();
    for (std::size_t i = 1; i < hypotheses_.size(); ++i) {
      const Hypothesis& other = hypotheses_[i];
      const double odds = best.tracked.known_log_likelihood - other.tracked.known_log_likelihood;
      if (odds < RequiredOdds() && other.tracked.evidence.known() >= options_.tenable_known &&
          !IsSamePlace(best, other)) {
        return &other;
      }
    }
    return nullptr;
  }

  // How far behind rivals must be.
  double RequiredOdds() const {
    const double misfit = -hypotheses_.front().tracked.known_log_likelihood;
    return std::clamp(options_.confident_misfit * misfit, options_.confident_odds, options_.listed_odds);
  }

  const Hypothesis* FindRival() const {
    for (std::size_t i = 1; i < hypotheses_.size(); ++i) {
      if (!IsSamePlace(hypotheses_.front(), hypotheses_[i])) return &hypotheses_[i];
    }
    return nullptr;
  }

  std::string FindDoubt() const {
    const TrackedPose& best = hypotheses_.front().tracked;
    const ScanEvidence& seen = best.evidence;
    if (seen.matched < options_.confident_matched * seen.known()) {
      return fmt::format("of the hits on known ground, {:.0f} % lie on walls", 100.0 * seen.matched / seen.known());
    }
    if (seen.contradicted() > options_.confident_contradicted) {
      return fmt::format("{:.0f} % of the hits lie in free space or behind walls", 100.0 * seen.contradicted());
    }
    if (seen.known() < options_.confident_known) {
      return fmt::format("only {:.0f} % of the hits lie on known ground", 100.0 * seen.known());
    }
    const double weakest = slam::WeakestDirection(best.T_map_robot.covariance.inverse());
    if (weakest > options_.confident_sigma) {
      return fmt::format("the position along the walls is known to {:.2f} m only", weakest);
    }
    if (best.T_map_robot.covariance(2, 2) > options_.confident_yaw_sigma * options_.confident_yaw_sigma) {
      return fmt::format("the heading is known to {:.2f} rad only", std::sqrt(best.T_map_robot.covariance(2, 2)));
    }
    if (const Hypothesis* rival = FindRival()) {
      const double odds = best.log_likelihood - rival->tracked.log_likelihood;
      if (odds < RequiredOdds()) {
        return rival->map == hypotheses_.front().map
                   ? fmt::format("another place, {:.1f} m away, fits nearly as well (log-odds {:.1f})",
                                 Between(best.T_map_robot.pose, rival->tracked.T_map_robot.pose).translation().norm(),
                                 odds)
                   : fmt::format("a place in another map fits nearly as well (log-odds {:.1f})", odds);
      }
    }
    if (const Hypothesis* other = FindHalfKnown()) {
      return fmt::format("nothing contradicts another place, where {:.0f} % of the hits lie on unknown ground",
                         100.0 * other->tracked.evidence.unknown);
    }
    // A place that fits all scans fits each of them: one complete search is enough.
    return incomplete_.size() < searched_.size() ? "" : "so many places look alike that not all were compared";
  }

  std::string Certainty() const {
    const TrackedPose& best = hypotheses_.front().tracked;
    const Hypothesis* rival = FindRival();
    const std::string others = rival == nullptr ? "nothing else fits"
                                                : fmt::format("log-odds {:.1f} ahead of the next place",
                                                              best.log_likelihood - rival->tracked.log_likelihood);
    return fmt::format("{:.0f} % of the hits lie on walls, {:.0f} % contradict, {}", 100.0 * best.evidence.matched,
                       100.0 * best.evidence.contradicted(), others);
  }

  const std::vector<TrackedScan> scans_;
  const std::vector<std::size_t> searched_;  // of scans_
  const std::vector<CandidateMap>& maps_;
  const LocalizationOptions& options_;
  const KeepGoing& keep_going_;
  std::vector<Seed> seeds_;
  std::vector<Hypothesis> hypotheses_;
  double best_likelihood_ = -std::numeric_limits<double>::infinity();
  std::set<std::size_t> incomplete_;  // scans for which some place may have been missed
};

}  // namespace

absl::StatusOr<Localization> Localize(const std::vector<QueryScan>& scans, const std::vector<CandidateMap>& maps,
                                      const LocalizationOptions& options, const KeepGoing& keep_going) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<TrackedScan> selected, SelectScans(scans, options));
  return Localizer(std::move(selected), maps, options, keep_going).Run();
}

absl::StatusOr<Localization> LocalizeIn(const std::shared_ptr<const SearchableMap>& map,
                                        const std::vector<QueryScan>& scans) {
  auto found = Localize(scans, {{[&map] { return map; }}}, LocalizationOptions(), [] { return absl::OkStatus(); });
  if (absl::IsInvalidArgument(found.status())) return Localization{{}, std::string(found.status().message())};
  return found;
}

}  // namespace enfilade::localization

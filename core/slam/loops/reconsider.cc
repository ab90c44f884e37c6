// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/reconsider.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/slam/matching/local_matching.h"

namespace enfilade::slam {
namespace {

constexpr std::size_t kMostConsidered = 200;  // the last ones: the search for agreement is cubic
constexpr double kLongest = 60.0;             // m, of the way between two closures that can be compared
// What two closures may differ by, apart from the drift between them.
constexpr double kSlack = 0.25;     // m
constexpr double kYawSlack = 0.06;  // rad
constexpr int kLeastKnownPoints = 50;

// The length driven up to each keyframe, and up to each submap's first.
struct Lengths {
  std::map<std::int64_t, double> node;
  std::map<std::int64_t, double> submap;
};

Lengths MeasureLengths(const MapperState& state) {
  Lengths lengths;
  double driven = 0.0;
  const auto add = [&](std::int64_t id, const std::vector<SubmapNode>& nodes) {
    lengths.submap[id] = driven;
    for (const SubmapNode& node : nodes) {
      if (!node.carried) lengths.node[node.node] = driven += node.length;
    }
  };
  for (const auto& [id, submap] : state.finished) add(id, submap.nodes);
  if (state.active) add(state.active->id, state.active->content.nodes);
  return lengths;
}

class Agreements {
 public:
  Agreements(const MapperState& state, const LoopOptions& options)
      : state_(state), options_(options), lengths_(MeasureLengths(state)) {}

  bool Agree(const LoopClosure& p, const LoopClosure& q) const {
    const double way = std::abs(lengths_.node.at(p.node) - lengths_.node.at(q.node)) +
                       std::abs(lengths_.submap.at(p.submap) - lengths_.submap.at(q.submap));
    if (way > kLongest) return false;
    const Pose2 by_p =
        p.T_submap_node * Between(state_.nodes.at(p.node).T_map_node, state_.nodes.at(q.node).T_map_node);
    const Pose2 by_q =
        Between(state_.finished.at(p.submap).T_map_submap, state_.finished.at(q.submap).T_map_submap) * q.T_submap_node;
    const Pose2 difference = Between(by_p, by_q);
    return difference.translation().norm() < kSlack + options_.drift_per_metre * way &&
           std::abs(difference.yaw) < kYawSlack + options_.yaw_drift_per_metre * way;
  }

  double LengthOf(const std::vector<const LoopClosure*>& closures) const {
    double first = lengths_.node.at(closures.front()->node);
    double last = first;
    for (const LoopClosure* closure : closures) {
      first = std::min(first, lengths_.node.at(closure->node));
      last = std::max(last, lengths_.node.at(closure->node));
    }
    return last - first;
  }

 private:
  const MapperState& state_;
  const LoopOptions& options_;
  Lengths lengths_;
};

// Matched, but rejected by the graph.
std::vector<const LoopClosure*> RefusedByGraph(const MapperState& state) {
  std::vector<const LoopClosure*> refused;
  for (const auto& [id, closure] : state.loop_closures) {
    if (closure.state != LoopClosureState::kRejected || closure.information.isZero()) continue;
    if (!state.is_existing_map(closure.submap)) refused.push_back(&closure);
  }
  if (refused.size() > kMostConsidered) {
    refused.erase(refused.begin(), refused.end() - static_cast<std::ptrdiff_t>(kMostConsidered));
  }
  return refused;
}

// How well the walls of the submaps joined by `closures` agree with each other's free space, in the poses of `state`.
Agreement AgreementOfWalls(const MapperState& state, const std::vector<std::int64_t>& closures,
                           const SlamOptions& options, SubmapCache& cache) {
  std::set<std::pair<std::int64_t, std::int64_t>> pairs;
  for (const std::int64_t id : closures) {
    const LoopClosure& closure = state.loop_closures.at(id);
    const std::int64_t other = state.nodes.at(closure.node).submap;
    if (!state.finished.contains(other)) continue;
    pairs.emplace(closure.submap, other);
    pairs.emplace(other, closure.submap);
  }
  double matched = 0.0;
  double contradicted = 0.0;
  Agreement sum;
  for (const auto& [id, other] : pairs) {
    const std::vector<Eigen::Vector2d> points = cache.Get(other, state.finished.at(other)).grid.OccupiedPoints();
    const SearchableSubmap& submap = cache.Get(id, state.finished.at(id));
    const Pose2 T_submap_other = Between(state.finished.at(id).T_map_submap, state.finished.at(other).T_map_submap);
    const Agreement agreement = MeasureAgreement(submap.grid, submap.pyramid.levels.back(), points, T_submap_other,
                                                 2.0 * options.local.field.matched_distance);
    matched += agreement.matched_share * agreement.hits;
    contradicted += agreement.contradicted_share * agreement.hits;
    sum.hits += agreement.hits;
  }
  if (sum.hits > 0 && matched + contradicted >= kLeastKnownPoints) {
    sum.matched_share = matched / sum.hits;
    sum.contradicted_share = contradicted / sum.hits;
  }
  return sum;
}

void PutTies(const std::map<std::int64_t, Eigen::Matrix3d>& ties, const SlamOptions& options,
             Reconsidered& reconsidered) {
  for (const auto& [id, information] : ties) {
    FinishedSubmap& submap = reconsidered.state.finished.at(id);
    SubmapContent content = DecodeSubmapContent(submap.content, options.occupancy).value();  // written by this program
    content.nodes = submap.nodes;
    content.next = submap.next;
    content.next->information = information;
    submap = FinishSubmap(submap.T_map_submap, submap.version + 1, Encode(content), content.nodes, content.next);
    reconsidered.contents.insert(id);
  }
}

bool Holds(const MapperState& before, const std::vector<std::int64_t>& wanted, const MapperState& after) {
  const auto accepted = [&after](std::int64_t id) {
    return after.loop_closures.at(id).state == LoopClosureState::kAccepted;
  };
  const auto lost = std::count_if(before.loop_closures.begin(), before.loop_closures.end(), [&](const auto& entry) {
    return entry.second.state == LoopClosureState::kAccepted && !accepted(entry.first);
  });
  const auto held = std::count_if(wanted.begin(), wanted.end(), accepted);
  return 3 * held >= 2 * static_cast<std::ptrdiff_t>(wanted.size()) && 4 * lost <= held;
}

}  // namespace

std::vector<std::int64_t> FindAgreeingClosures(const MapperState& state, const LoopOptions& options) {
  const std::vector<const LoopClosure*> refused = RefusedByGraph(state);
  const Agreements agreements(state, options);
  std::vector<const LoopClosure*> best;
  for (const LoopClosure* first : refused) {
    std::vector<const LoopClosure*> set = {first};
    for (const LoopClosure* other : refused) {
      const bool agrees = std::all_of(set.begin(), set.end(), [&](const LoopClosure* member) {
        return member != other && agreements.Agree(*member, *other);
      });
      if (agrees) set.push_back(other);
    }
    if (set.size() > best.size()) best = std::move(set);
  }
  std::vector<std::int64_t> ids;
  if (best.size() < static_cast<std::size_t>(options.min_agreeing) ||
      agreements.LengthOf(best) < options.min_agreeing_length) {
    return ids;
  }
  for (const LoopClosure* closure : best) ids.push_back(closure->id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::optional<Reconsidered> ReconsiderClosures(const MapperState& state, const SlamOptions& options,
                                               SubmapCache& cache) {
  const std::vector<std::int64_t> agreeing = FindAgreeingClosures(state, options.loop);
  if (agreeing.empty()) return std::nullopt;
  Reconsidered reconsidered{state, {}, {}};
  const auto ties = LoosenTies(options.graph, {agreeing.begin(), agreeing.end()}, reconsidered.state);
  if (ties.empty()) return std::nullopt;
  PutTies(ties, options, reconsidered);
  reconsidered.change = SolveSlamGraph(options.graph, reconsidered.state);
  if (!Holds(state, agreeing, reconsidered.state)) return std::nullopt;
  const Agreement walls = AgreementOfWalls(reconsidered.state, agreeing, options, cache);
  if (walls.agreement() < options.loop.min_entry_agreement) return std::nullopt;
  return reconsidered;
}

}  // namespace enfilade::slam

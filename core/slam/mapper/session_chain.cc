// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/session_chain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/loops/edge_information.h"
#include "core/slam/mapper/locate_scan.h"
#include "core/slam/matching/local_matching.h"
#include "core/slam/submaps/robot_rays.h"

namespace enfilade::slam {
namespace {

// Bytes. Larger pictures are drawn from the start each time.
constexpr std::size_t kMostTiles = 64U << 20U;

// For submaps, and as much for their pyramids, while sessions are appended: each is needed several times.
constexpr std::size_t kKeptBytes = 64U << 20U;

// How many of a session's keyframes are matched to the last submap before it, and how far from the first, m.
constexpr int kTieKeyframes = 5;
constexpr double kTieLength = 2.0;

// A session's submaps, nodes and loop closures by their numbers in the chain, its poses still in its own frame.
struct Renumbered {
  std::map<std::int64_t, FinishedSubmap> submaps;
  std::map<std::int64_t, SubmapGrid> grids;  // of the submaps
  std::map<std::int64_t, SlamNode> nodes;
  std::map<std::int64_t, std::vector<LoopClosure>> closures;  // by node, without ids
  std::vector<TrajectoryPoint> trajectory;
};

class Renumbering {
 public:
  Renumbering(const SlamMap& map, std::int64_t first_submap, std::int64_t first_node, const SlamOptions& options)
      : map_(map), options_(options) {
    for (const auto& [id, submap] : map.submaps) submaps_[id] = first_submap++;
    for (const auto& [id, node] : map.nodes) nodes_[id] = first_node++;
  }

  absl::StatusOr<Renumbered> Run() const {
    Renumbered result;
    for (const auto& [id, row] : map_.submaps) {
      ENFILADE_RETURN_IF_ERROR(AddSubmap(row, result));
    }
    for (const auto& [id, row] : map_.nodes) {
      SlamNode node = row;
      node.id = nodes_.at(id);
      const auto submap = submaps_.find(row.submap);
      if (submap == submaps_.end()) return FailedPrecondition("submap {} of keyframe {} is missing", row.submap, id);
      node.submap = submap->second;
      result.nodes[node.id] = node;
    }
    if (result.nodes.begin()->second.submap != result.submaps.begin()->first) {
      return FailedPrecondition("the keyframes of the first submap are missing");
    }
    for (const auto& [id, row] : map_.loop_closures) {
      const auto node = nodes_.find(row.node);
      const auto submap = submaps_.find(row.submap);
      if (node == nodes_.end() || submap == submaps_.end()) continue;
      LoopClosure closure = row;
      closure.node = node->second;
      closure.submap = submap->second;
      result.closures[closure.node].push_back(std::move(closure));
    }
    for (TrajectoryPoint point : map_.trajectory) {
      const auto node = nodes_.find(point.node);
      if (node == nodes_.end()) continue;
      point.node = node->second;
      result.trajectory.push_back(point);
    }
    return result;
  }

 private:
  absl::Status AddSubmap(const SlamSubmap& row, Renumbered& result) const {
    if (!row.finished) return FailedPrecondition("submap {} is not finished", row.id);
    absl::StatusOr<SubmapContent> content = DecodeSubmapContent(row.content, options_.occupancy);
    if (!content.ok()) return WithContext(content.status(), "a session's submap");
    if (content->grid.resolution() != options_.resolution) {
      return FailedPrecondition("the resolution of submap {} is {} m, not {} m", row.id, content->grid.resolution(),
                                options_.resolution);
    }
    std::vector<SubmapNode> nodes;
    for (SubmapNode& node : content->nodes) {
      const auto number = nodes_.find(node.node);
      if (number == nodes_.end()) continue;
      node.node = number->second;
      nodes.push_back(std::move(node));
    }
    if (nodes.empty()) return FailedPrecondition("the keyframes of submap {} are missing", row.id);
    const bool is_last = row.id == map_.submaps.rbegin()->first;
    if (is_last) {
      content->next.reset();
    } else if (!content->next || !submaps_.contains(row.id + 1)) {
      return FailedPrecondition("the submap after {} is missing", row.id);
    }
    const std::int64_t number = submaps_.at(row.id);
    result.submaps[number] = FinishSubmap(row.T_map_submap, row.version, row.content, nodes, content->next);
    result.grids.emplace(number, std::move(content->grid));
    return absl::OkStatus();
  }

  const SlamMap& map_;
  const SlamOptions& options_;
  std::map<std::int64_t, std::int64_t> submaps_;  // by the session's number
  std::map<std::int64_t, std::int64_t> nodes_;
};

// That of a record, or one that shows nothing.
sensor::PairedScan FindScan(const std::vector<sensor::PairedScan>& scans, std::int64_t sequence, TimeNs time) {
  const auto found =
      std::lower_bound(scans.begin(), scans.end(), sequence,
                       [](const sensor::PairedScan& scan, std::int64_t wanted) { return scan.sequence < wanted; });
  if (found != scans.end() && found->sequence == sequence) return *found;
  sensor::PairedScan none;
  none.sequence = sequence;
  none.scan.time = time;
  return none;
}

// Where the session ended, in its last submap.
Track EndOf(const Renumbered& session, const std::vector<sensor::PairedScan>& scans) {
  const Pose2& T_session_submap = session.submaps.rbegin()->second.T_map_submap;
  Track end;
  if (session.trajectory.empty()) {
    const SlamNode& node = session.nodes.rbegin()->second;
    end.T_submap_robot = Between(T_session_submap, node.T_map_node);
    end.time = end.matched_at = node.time;
    return end;
  }
  const TrajectoryPoint& last = session.trajectory.back();
  const auto pose_at = [&](const TrajectoryPoint& point) {
    return session.nodes.at(point.node).T_map_node * point.T_node_robot;
  };
  end.T_submap_robot = Between(T_session_submap, pose_at(last));
  end.T_odom_robot = FindScan(scans, last.sequence, last.time).T_odom_robot;
  end.time = end.matched_at = last.time;
  end.length_since_keyframe = last.T_node_robot.translation().norm();
  if (session.trajectory.size() > 1) {
    const TrajectoryPoint& before = *std::prev(session.trajectory.end(), 2);
    end.last_step = Step{Between(pose_at(before), pose_at(last)), ToSeconds(last.time - before.time)};
  }
  return end;
}

}  // namespace

SessionChain::SessionChain(const SlamOptions& options, const std::optional<ExistingMap>& existing)
    : options_(options), back_end_(options, kKeptBytes) {
  if (!existing) return;
  state_.entry = existing->entry;
  state_.finished[0] = FinishExistingMap(1, ContentOf(existing->grid, options_));
}

absl::Status SessionChain::Append(const ChainedSession& session) {
  if (session.map.nodes.empty()) return absl::OkStatus();
  const Renumbering renumbering(session.map, state_.last_submap() + 1, static_cast<std::int64_t>(state_.nodes.size()),
                                options_);
  ENFILADE_ASSIGN_OR_RETURN(Renumbered added, renumbering.Run());
  const Track end = EndOf(added, session.scans);
  const SlamNode& first = added.nodes.begin()->second;
  FinishedSubmap& submap = added.submaps.begin()->second;
  const sensor::PairedScan first_scan = FindScan(session.scans, first.sequence, first.time);
  const Pose2 T_first_submap = Between(first.T_map_node, submap.T_map_submap);
  const Pose2 T_chain_session =
      Tie(first_scan, SeenFirst(added.nodes, session.scans), T_first_submap, submap) * Inverse(submap.T_map_submap);

  for (auto& [id, one] : added.submaps) {
    one.T_map_submap = T_chain_session * one.T_map_submap;
    state_.finished[id] = std::move(one);
  }
  for (auto& [id, grid] : added.grids) back_end_.submaps().Put(id, std::move(grid));
  for (auto& [id, node] : added.nodes) {
    node.T_map_node = T_chain_session * node.T_map_node;
    state_.nodes[id] = node;
  }
  trajectory_.insert(trajectory_.end(), added.trajectory.begin(), added.trajectory.end());
  state_.errors.match_squares += session.errors.match_squares;
  state_.errors.matches += session.errors.matches;
  state_.track = end;
  for (const auto& [id, node] : added.nodes) {
    for (LoopClosure& closure : added.closures[id]) {
      closure.id = static_cast<std::int64_t>(state_.loop_closures.size());
      back_end_.Add({std::move(closure)}, state_);
    }
    const sensor::PairedScan scan = FindScan(session.scans, node.sequence, node.time);
    if (!options_.close_loops || !options_.match_scans || scan.scan.ranges.empty()) continue;
    back_end_.CloseLoops(state_.nodes.at(id), RaysOf(scan), state_);
  }
  back_end_.changes() = {};  // nobody stores the rows
  return absl::OkStatus();
}

grid::ScanRays SessionChain::RaysOf(const sensor::PairedScan& scan) const {
  return RobotRays(scan.scan, {options_.max_range, options_.occupancy.no_return_range});
}

// What a session's first keyframes have seen, in the frame of the first one: several scans show where it is more surely
// than one.
grid::ScanRays SessionChain::SeenFirst(const std::map<std::int64_t, SlamNode>& nodes,
                                       const std::vector<sensor::PairedScan>& scans) const {
  grid::ScanRays seen;
  const SlamNode& first = nodes.begin()->second;
  int count = 0;
  for (const auto& [id, node] : nodes) {
    const Pose2 T_first_node = Between(first.T_map_node, node.T_map_node);
    if (count++ == kTieKeyframes || T_first_node.translation().norm() > kTieLength) break;
    const grid::ScanRays rays = Transformed(T_first_node, RaysOf(FindScan(scans, node.sequence, node.time)));
    seen.hits.insert(seen.hits.end(), rays.hits.begin(), rays.hits.end());
  }
  return seen;
}

// Ties `submap`, with which a session begins, to what is there. Returns its pose. `scan`: the first one; `seen`: by it
// and those after it.
Pose2 SessionChain::Tie(const sensor::PairedScan& scan, const grid::ScanRays& seen, const Pose2& T_robot_submap,
                        FinishedSubmap& submap) {
  if (!state_.track) {
    if (!state_.entry) return T_robot_submap;
    PoseWithCovariance T_map_first = PoseAtScan(*state_.entry, scan.T_odom_robot, options_);
    T_map_first.pose = T_map_first.pose * T_robot_submap;
    state_.finished[0] = TiedToFirst(state_.finished.at(0), T_map_first, options_);
    return T_map_first.pose;
  }
  FinishedSubmap& last = state_.finished.at(state_.last_submap());
  const SubmapGrid& grid = back_end_.submaps().GetGrid(state_.last_submap(), last);
  LocalFields fields(options_.resolution, options_.local);
  fields.Rebuild(grid);
  const LocatedScan located = LocateScan(*state_.track, scan, seen, {grid, fields}, options_);
  if (located.residual) {
    state_.errors.match_squares += std::pow(*located.residual / options_.local.field.sigma, 2);
    ++state_.errors.matches;
  }
  submap.nodes.front().length += located.track.length_since_keyframe;
  submap.length += located.track.length_since_keyframe;
  last.next =
      NextSubmap{located.track.T_submap_robot * T_robot_submap,
                 WithFloor(located.information, options_.graph.match_sigma_floor, options_.graph.match_yaw_floor)};
  return last.T_map_submap * last.next->T_submap_next;
}

ChainedMap SessionChain::Finish() {
  MapperState finished = state_;
  if (options_.match_scans) back_end_.Finish(true, finished);
  std::map<std::int64_t, Pose2> T_map_submaps;
  for (const auto& [id, submap] : finished.finished) {
    if (!finished.is_existing_map(id)) T_map_submaps[id] = submap.T_map_submap;
  }
  if (!renderer_) renderer_.emplace(options_.resolution, LogOddsOptionsOf(options_.occupancy));
  renderer_->Expect(T_map_submaps);
  for (const auto& [id, T_map_submap] : T_map_submaps) {
    renderer_->Place(id, T_map_submap, [&, id = id]() -> const SubmapGrid& {
      return back_end_.submaps().GetGrid(id, finished.finished.at(id));
    });
  }
  ChainedMap result{renderer_->Render(nullptr, {}), TrajectoryOf(finished.nodes, trajectory_),
                    VarianceFactor(finished.errors)};
  std::sort(result.trajectory.begin(), result.trajectory.end(),
            [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
  if (renderer_->bytes() > kMostTiles) renderer_.reset();
  back_end_ = BackEnd(options_, kKeptBytes);  // its cache is needed while sessions are appended
  return result;
}

std::size_t SessionChain::bytes() const {
  return sizeof(*this) + KeptBytes(state_) + trajectory_.size() * sizeof(TrajectoryPoint) + back_end_.bytes() +
         (renderer_ ? renderer_->bytes() : 0);
}

}  // namespace enfilade::slam

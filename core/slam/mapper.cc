#include "core/slam/mapper.h"

#include <cmath>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/edge_information.h"
#include "core/slam/local_matching.h"
#include "core/slam/loop_candidates.h"
#include "core/slam/loop_matching.h"
#include "core/slam/map_renderer.h"
#include "core/slam/mapper_state.h"
#include "core/slam/motion_model.h"
#include "core/slam/scan_points.h"
#include "core/slam/slam_graph.h"
#include "core/slam/submap_cache.h"

namespace enfilade {
namespace {

bool IsFarEnough(const Pose2& T_last_now, const KeyframeOptions& options) {
  return T_last_now.translation().norm() >= options.distance || std::abs(T_last_now.yaw) >= options.angle;
}

bool IsFull(const Submap& submap, const Pose2& T_submap_robot, const SubmapOptions& options) {
  return submap.own_nodes() >= options.max_keyframes || T_submap_robot.translation().norm() > options.max_extent;
}

}  // namespace

class Mapper::Impl {
 public:
  explicit Impl(const SlamOptions& options)
      : options_(options), cache_(options), renderer_(options.resolution, LogOddsOptionsOf(options.occupancy)) {}

  Impl(const SlamOptions& options, MapperState state) : Impl(options) {
    state_ = std::move(state);
    if (!state_.active) return;
    fields_.emplace(options_.resolution, options_.local);
    fields_->Rebuild(state_.active->content.grid);
  }

  ScanReport AddScan(const PairedScan& scan) {
    ScanReport report;
    if (!scan.T_odom_robot && !options_.match_scans) {
      report.reason = "no odometry at the scan's time";
      return report;
    }
    const ScanRays rays = RobotRays(scan.scan, {options_.max_range, options_.occupancy.no_return_range});
    if (!state_.active) BeginFirstSubmap();
    Track track = state_.track.value_or(Track{});
    information_ = InformationOf(0.05, 0.02);
    if (state_.track) {
      const PredictedMotion motion =
          PredictMotion(track.T_odom_robot, scan.T_odom_robot, track.T_before_last, options_.motion);
      Pose2 next = track.T_submap_robot * motion.T_last_now;
      if (options_.match_scans) {
        const LocalMatch m = MatchLocally(state_.active->content.grid, *fields_, rays.hits, track.T_submap_robot,
                                          motion, options_.local);
        next = m.match.T_submap_robot;
        report.matched_share = m.agreement.matched_share;
        report.lost = !m.good;
        information_ = m.match.information + InformationOf(motion.sigma_translation, motion.sigma_yaw);
      }
      track.T_before_last = Between(track.T_submap_robot, next);
      track.length_since_keyframe += track.T_before_last->translation().norm();
      track.T_submap_robot = next;
    }
    track.T_odom_robot = scan.T_odom_robot;
    state_.track = track;
    report.used = true;
    report.keyframe =
        state_.nodes.empty() || IsFarEnough(Between(LastNode().T_submap_node, track.T_submap_robot), options_.keyframe);
    if (report.keyframe) AddKeyframe(scan, rays);
    delta_.trajectory.push_back({scan.sequence, scan.scan.time, LastNode().node,
                                 Between(LastNode().T_submap_node, state_.track->T_submap_robot)});
    return report;
  }

  void Finish() {
    if (!state_.ended && state_.active) FinishActive(std::nullopt);
    state_.ended = true;
    if (options_.match_scans) Solve();
  }

  SlamDelta TakeDelta() {
    for (const std::int64_t id : touched_nodes_) delta_.nodes.push_back(state_.nodes.at(id));
    for (const std::int64_t id : touched_submaps_) delta_.submaps.push_back(RowOf(id));
    for (const std::int64_t id : touched_closures_) delta_.closures.push_back(state_.closures.at(id));
    touched_nodes_.clear();
    touched_submaps_.clear();
    touched_closures_.clear();
    new_contents_.clear();
    return std::exchange(delta_, SlamDelta{});
  }

  std::string Checkpoint() const { return EncodeCheckpoint(state_); }

  OccupancyGrid RenderGrid() const {
    for (const auto& [id, submap] : state_.finished) {
      std::optional<SubmapContent> content;
      renderer_.Place(id, submap.T_map_submap, [&]() -> const SubmapGrid& {
        content = DecodeSubmapContent(submap.content, options_.occupancy).value();  // our own bytes
        return content->grid;
      });
    }
    if (!state_.active) return renderer_.Render(nullptr, {});
    return renderer_.Render(&state_.active->content.grid, state_.active->T_map_submap);
  }

 private:
  const SubmapNode& LastNode() const { return state_.active->content.nodes.back(); }

  void BeginFirstSubmap() {
    state_.active = Submap{0, 0, Pose2{}, {{}, {}, {}, SubmapGrid(options_.resolution, options_.occupancy)}};
    fields_.emplace(options_.resolution, options_.local);
  }

  void Insert(SubmapGrid& grid, const Pose2& T_submap_robot, const ScanRays& rays) {
    const auto changed = grid.Insert(T_submap_robot, rays);
    if (changed.ok()) fields_->Update(grid, *changed);
  }

  void AddKeyframe(const PairedScan& scan, const ScanRays& rays) {
    if (IsFull(*state_.active, state_.track->T_submap_robot, options_.submap)) BeginNextSubmap();
    Submap& submap = *state_.active;
    const Pose2 T_submap_robot = state_.track->T_submap_robot;
    const auto id = static_cast<std::int64_t>(state_.nodes.size());
    const double length = state_.track->length_since_keyframe;
    state_.track->length_since_keyframe = 0.0;
    Insert(submap.content.grid, T_submap_robot, rays);
    submap.content.nodes.push_back({id, false, length, T_submap_robot, NodeInformation()});
    submap.content.scans.push_back(rays);
    ++submap.version;
    SlamNode node;
    node.id = id;
    node.sequence = scan.sequence;
    node.time = scan.scan.time;
    node.T_map_node = submap.T_map_submap * T_submap_robot;
    node.submap = submap.id;
    state_.nodes[id] = node;
    touched_nodes_.insert(id);
    touched_submaps_.insert(submap.id);
    if (options_.close_loops && options_.match_scans) CloseLoops(node, rays);
  }

  Eigen::Matrix3d NodeInformation() const {
    return WithFloor(information_, options_.graph.match_sigma_floor, options_.graph.match_yaw_floor);
  }

  void CloseLoops(const SlamNode& node, const ScanRays& rays) {
    bool urgent = false;
    for (const LoopCandidate& candidate : SelectLoopCandidates(state_, node, options_.loop)) {
      const FinishedSubmap& submap = state_.finished.at(candidate.submap);
      const SubmapCache::Entry& entry = cache_.Get(candidate.submap, submap);
      const Pose2 guess = Between(submap.T_map_submap, node.T_map_node);
      const LoopMatch match = MatchLoop(entry.grid, entry.pyramid, rays.hits, guess, candidate, options_);
      SlamClosure closure;
      closure.id = static_cast<std::int64_t>(state_.closures.size());
      closure.submap = candidate.submap;
      closure.node = node.id;
      closure.T_submap_node = match.T_submap_node;
      closure.information = match.information;
      closure.state = match.accepted ? ClosureState::kAccepted : ClosureState::kRejected;
      closure.score = match.score;
      closure.reason = match.reason;
      state_.closures[closure.id] = closure;
      touched_closures_.insert(closure.id);
      if (!match.accepted) continue;
      state_.unsolved_closures = true;
      urgent = urgent || ClosureChi2(state_, closure) > options_.graph.urgent_chi2;
    }
    const auto nodes = static_cast<double>(state_.nodes.size());
    const bool grown = nodes > static_cast<double>(state_.nodes_at_solve) * (1.0 + options_.graph.growth);
    if (urgent || (state_.unsolved_closures && grown)) Solve();
  }

  void Solve() {
    const GraphChange change = SolveSlamGraph(options_.graph, state_);
    touched_nodes_.insert(change.nodes.begin(), change.nodes.end());
    touched_submaps_.insert(change.submaps.begin(), change.submaps.end());
    touched_closures_.insert(change.closures.begin(), change.closures.end());
    state_.nodes_at_solve = static_cast<std::int64_t>(state_.nodes.size());
    state_.unsolved_closures = false;
  }

  // The new submap's origin is the present pose; the last keyframes are copied over into it.
  void BeginNextSubmap() {
    const Pose2 T_old_new = state_.track->T_submap_robot;
    const Submap old = FinishActive(NextSubmap{T_old_new, NodeInformation()});
    fields_.emplace(options_.resolution, options_.local);
    Submap next{
        old.id + 1, 0, old.T_map_submap * T_old_new, {{}, {}, {}, SubmapGrid(options_.resolution, options_.occupancy)}};
    const std::size_t count = old.content.nodes.size();
    const std::size_t carried = std::min(count, static_cast<std::size_t>(options_.submap.carried_keyframes));
    for (std::size_t i = count - carried; i < count; ++i) {
      SubmapNode node = old.content.nodes[i];
      node.carried = true;
      node.T_submap_node = Between(T_old_new, node.T_submap_node);
      Insert(next.content.grid, node.T_submap_node, old.content.scans[i]);
      next.content.nodes.push_back(node);
      next.content.scans.push_back(old.content.scans[i]);
    }
    state_.track->T_submap_robot = Pose2{};
    state_.active = std::move(next);
  }

  Submap FinishActive(const std::optional<NextSubmap>& next) {
    Submap old = *std::exchange(state_.active, std::nullopt);
    ++old.version;
    old.content.next = next;
    state_.finished[old.id] = Finished(old.T_map_submap, old.version, Encode(old.content), old.content.nodes, next);
    touched_submaps_.insert(old.id);
    new_contents_.insert(old.id);
    return old;
  }

  SlamSubmap RowOf(std::int64_t id) const {
    SlamSubmap row;
    row.id = id;
    if (state_.active && state_.active->id == id) {
      row.version = state_.active->version;
      row.T_map_submap = state_.active->T_map_submap;
      return row;
    }
    const FinishedSubmap& submap = state_.finished.at(id);
    row.version = submap.version;
    row.T_map_submap = submap.T_map_submap;
    row.finished = true;
    if (new_contents_.contains(id)) row.content = submap.content;
    return row;
  }

  SlamOptions options_;
  MapperState state_;
  std::optional<LocalFields> fields_;
  Eigen::Matrix3d information_;
  SubmapCache cache_;
  SlamDelta delta_;
  std::set<std::int64_t> touched_nodes_;
  std::set<std::int64_t> touched_submaps_;
  std::set<std::int64_t> touched_closures_;
  std::set<std::int64_t> new_contents_;
  mutable MapRenderer renderer_;  // a cache: what it gives depends on the state only
};

Mapper::Mapper(const SlamOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Mapper::Mapper(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

absl::StatusOr<Mapper> Mapper::Restore(const SlamOptions& options, const SlamMap& stored, std::string_view checkpoint) {
  ENFILADE_ASSIGN_OR_RETURN(MapperState state, DecodeCheckpoint(checkpoint, stored, options.occupancy));
  return Mapper(std::make_unique<Impl>(options, std::move(state)));
}

ScanReport Mapper::AddScan(const PairedScan& scan) { return impl_->AddScan(scan); }
void Mapper::Finish() { impl_->Finish(); }
SlamDelta Mapper::TakeDelta() { return impl_->TakeDelta(); }
std::string Mapper::Checkpoint() const { return impl_->Checkpoint(); }
OccupancyGrid Mapper::RenderGrid() const { return impl_->RenderGrid(); }

}  // namespace enfilade

// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/mapper.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/status_macros.h"
#include "core/slam/loops/edge_information.h"
#include "core/slam/mapper/back_end.h"
#include "core/slam/mapper/locate_scan.h"
#include "core/slam/mapper/map_renderer.h"
#include "core/slam/mapper/policies.h"
#include "core/slam/matching/local_matching.h"
#include "core/slam/state/checkpoint.h"
#include "core/slam/state/mapper_state.h"
#include "core/slam/submaps/robot_rays.h"

namespace enfilade::slam {
namespace {

ScanReport NotUsed(std::string reason) {
  ScanReport report;
  report.reason = std::move(reason);
  return report;
}

}  // namespace

class Mapper::Impl {
 public:
  explicit Impl(const SlamOptions& options)
      : options_(options), back_end_(options), renderer_(options.resolution, LogOddsOptionsOf(options.occupancy)) {}

  Impl(const SlamOptions& options, const ExistingMap& existing_map) : Impl(options) {
    state_.entry = existing_map.entry;
    state_.finished[0] = FinishExistingMap(1, ContentOf(existing_map.grid, options_));
    back_end_.changes().MarkContent(0);
  }

  Impl(const SlamOptions& options, MapperState state) : Impl(options) {
    state_ = std::move(state);
    if (!state_.active) return;
    fields_.emplace(options_.resolution, options_.local);
    fields_->Rebuild(state_.active->content.grid);
  }

  ScanReport AddScan(const sensor::PairedScan& scan) {
    if (state_.ended) return NotUsed("the map is finished");
    if (!scan.T_odom_robot && !options_.match_scans) return NotUsed("no odometry at the scan's time");
    const grid::ScanRays rays = RobotRays(scan.scan, {options_.max_range, options_.occupancy.no_return_range});
    if (rays.hits.empty() && options_.match_scans && (!state_.track || !scan.T_odom_robot)) {
      return NotUsed("no beam hit anything in range");
    }
    const LocatedScan located =
        state_.track ? LocateScan(*state_.track, scan, rays, {state_.active->content.grid, *fields_}, options_)
                     : Begin(scan, rays);
    state_.track = located.track;
    const bool is_elsewhere = IsElsewhere(located.track.quality, options_.quality);
    const bool is_keyframe =
        state_.nodes.empty() || is_elsewhere ||
        IsKeyframeDue(Between(LastNode().T_submap_node, located.track.T_submap_robot), options_.keyframe);
    ScanReport report;
    report.used = true;
    report.keyframe = is_keyframe && (located.may_insert || is_elsewhere);
    if (report.keyframe) AddKeyframe(scan, rays, located.information);
    if (report.keyframe && located.residual) {
      state_.errors.match_squares += std::pow(*located.residual / options_.local.field.sigma, 2);
      ++state_.errors.matches;
    }
    report.lost = IsLost(state_.track->quality, options_.quality) || state_.adrift_since.has_value();
    report.matched_share = located.matched_share;
    if (options_.match_scans) report.match_age = ToSeconds(state_.track->time - state_.track->matched_at);
    back_end_.changes().Append({scan.sequence, scan.scan.time, LastNode().node,
                                Between(LastNode().T_submap_node, state_.track->T_submap_robot)});
    return report;
  }

  void Finish() {
    const bool is_first = !state_.ended;
    if (is_first && state_.active) FinishActive(std::nullopt);
    state_.ended = true;
    if (options_.match_scans) back_end_.Finish(is_first, state_);
  }

  SlamDelta TakeDelta() { return back_end_.changes().Take(state_); }

  std::string Checkpoint() const { return EncodeCheckpoint(state_); }

  Footprint footprint() const {
    Footprint footprint;
    footprint.kept = KeptBytes(state_);
    footprint.working = back_end_.bytes();
    if (state_.active) footprint.working += state_.active->bytes() + fields_->bytes();
    footprint.raster = renderer_.bytes();
    return footprint;
  }

  grid::OccupancyGrid RenderGrid() const { return RenderGrid(renderer_); }

  // The last submap is not placed, even if it is finished: a mapper that goes on from an earlier checkpoint adds to it.
  grid::OccupancyGrid RenderGrid(MapRenderer& renderer) const {
    std::map<std::int64_t, Pose2> T_map_submaps;
    for (const auto& [id, submap] : state_.finished) {
      if (!state_.is_existing_map(id) && id != state_.last_submap()) T_map_submaps[id] = submap.T_map_submap;
    }
    renderer.Expect(T_map_submaps);
    for (const auto& [id, T_map_submap] : T_map_submaps) {
      std::optional<SubmapContent> content;
      renderer.Place(id, T_map_submap, [&, id = id]() -> const SubmapGrid& {
        content = Decoded(state_.finished.at(id));
        return content->grid;
      });
    }
    if (state_.active) return renderer.Render(&state_.active->content.grid, state_.active->T_map_submap);
    const auto last = state_.finished.find(state_.last_submap());
    if (last == state_.finished.end() || state_.is_existing_map(last->first)) return renderer.Render(nullptr, {});
    const SubmapContent content = Decoded(last->second);
    return renderer.Render(&content.grid, last->second.T_map_submap);
  }

  double variance_factor() const { return VarianceFactor(state_.errors); }

  std::optional<PresentPose> PoseNow() const { return enfilade::slam::FindPresentPose(state_, options_.quality); }

 private:
  // Written by this program.
  SubmapContent Decoded(const FinishedSubmap& submap) const {
    return DecodeSubmapContent(submap.content, options_.occupancy).value();
  }

  const SubmapNode& LastNode() const { return state_.active->content.nodes.back(); }

  LocatedScan Begin(const sensor::PairedScan& scan, const grid::ScanRays& rays) {
    Submap first{0, 0, Pose2{}, EmptyContent()};
    if (state_.entry) {
      const PoseWithCovariance T_map_first = LocateAtEntry(*state_.entry, scan, rays, options_);
      state_.entry->seen.reset();
      first.id = 1;
      first.T_map_submap = T_map_first.pose;
      state_.finished[0] = TiedToFirst(state_.finished.at(0), T_map_first, options_);
      back_end_.changes().MarkContent(0);
    }
    state_.active = std::move(first);
    fields_.emplace(options_.resolution, options_.local);
    return LocateFirstScan(scan);
  }

  void AddKeyframe(const sensor::PairedScan& scan, const grid::ScanRays& rays, const Eigen::Matrix3d& information) {
    const Eigen::Matrix3d floored =
        WithFloor(information, options_.graph.match_sigma_floor, options_.graph.match_yaw_floor);
    if (IsElsewhere(state_.track->quality, options_.quality)) {
      BeginSubmapElsewhere();
    } else if (IsSubmapFull(*state_.active, state_.track->T_submap_robot, options_.submap)) {
      BeginNextSubmap(floored);
    }
    Submap& submap = *state_.active;
    SlamNode node;
    node.id = static_cast<std::int64_t>(state_.nodes.size());
    node.sequence = scan.sequence;
    node.time = scan.scan.time;
    node.T_map_node = submap.T_map_submap * state_.track->T_submap_robot;
    node.submap = submap.id;
    Insert({node.id, false, std::exchange(state_.track->length_since_keyframe, 0.0), state_.track->T_submap_robot,
            floored},
           rays);
    ++submap.version;
    state_.nodes[node.id] = node;
    back_end_.changes().MarkNode(node.id);
    back_end_.changes().MarkSubmap(submap.id);
    if (options_.close_loops && options_.match_scans) back_end_.CloseLoops(node, rays, state_);
  }

  // Adds a keyframe to the active submap. If the grid refuses the scan (absurdly far away), only the pose is added.
  void Insert(SubmapNode node, const grid::ScanRays& rays) {
    SubmapContent& content = state_.active->content;
    const auto changed = content.grid.Insert(node.T_submap_node, rays);
    if (changed.ok()) fields_->Update(content.grid, *changed);
    content.nodes.push_back(std::move(node));
    content.scans.push_back(rays);
  }

  SubmapContent EmptyContent() const { return {{}, {}, {}, SubmapGrid(options_.resolution, options_.occupancy)}; }

  // Finishes the active submap and begins one with its origin at the robot. Returns the finished one.
  Submap BeginSubmap(const Eigen::Matrix3d& information) {
    const Pose2 T_last_new = std::exchange(state_.track->T_submap_robot, Pose2{});
    Submap last = FinishActive(NextSubmap{T_last_new, information});
    fields_.emplace(options_.resolution, options_.local);
    state_.active = Submap{last.id + 1, 0, last.T_map_submap * T_last_new, EmptyContent()};
    return last;
  }

  // Begins a submap with copies of the last keyframes of the one before.
  void BeginNextSubmap(const Eigen::Matrix3d& information) {
    const Submap last = BeginSubmap(information);
    const std::size_t count = last.content.nodes.size();
    const std::size_t carried = std::min(count, static_cast<std::size_t>(options_.submap.carried_keyframes));
    for (std::size_t i = count - carried; i < count; ++i) {
      SubmapNode node = last.content.nodes[i];
      node.carried = true;
      node.T_submap_node = Between(last.content.next->T_submap_next, node.T_submap_node);
      Insert(std::move(node), last.content.scans[i]);
    }
  }

  // Begins an empty submap at the estimated pose, tied to the last one so weakly that it is free until it is
  // recognised.
  void BeginSubmapElsewhere() {
    BeginSubmap(LostTie());
    state_.track->quality = {};
    state_.track->last_step.reset();
    state_.track->length_since_keyframe += options_.quality.lost_length;
    if (!state_.adrift_since) state_.adrift_since = state_.active->id;
  }

  Submap FinishActive(const std::optional<NextSubmap>& next) {
    Submap last = *std::exchange(state_.active, std::nullopt);
    ++last.version;
    last.content.next = next;
    state_.finished[last.id] =
        FinishSubmap(last.T_map_submap, last.version, Encode(last.content), last.content.nodes, next);
    back_end_.changes().MarkContent(last.id);
    return last;
  }

  SlamOptions options_;
  MapperState state_;
  BackEnd back_end_;
  // Derived from the state, kept to save work.
  std::optional<LocalFields> fields_;
  mutable MapRenderer renderer_;
};

Mapper::Mapper(const SlamOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Mapper::Mapper(const SlamOptions& options, const ExistingMap& existing_map)
    : impl_(std::make_unique<Impl>(options, existing_map)) {}
Mapper::Mapper(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

absl::StatusOr<Mapper> Mapper::Restore(const SlamOptions& options, const SlamMap& stored, std::string_view checkpoint) {
  ENFILADE_ASSIGN_OR_RETURN(MapperState state, DecodeCheckpoint(checkpoint, stored, options.occupancy));
  return Mapper(std::make_unique<Impl>(options, std::move(state)));
}

ScanReport Mapper::AddScan(const sensor::PairedScan& scan) { return impl_->AddScan(scan); }
void Mapper::Finish() { impl_->Finish(); }
SlamDelta Mapper::TakeDelta() { return impl_->TakeDelta(); }
std::string Mapper::Checkpoint() const { return impl_->Checkpoint(); }
Footprint Mapper::footprint() const { return impl_->footprint(); }
double Mapper::variance_factor() const { return impl_->variance_factor(); }
grid::OccupancyGrid Mapper::RenderGrid() const { return impl_->RenderGrid(); }
grid::OccupancyGrid Mapper::RenderGrid(MapRenderer& renderer) const { return impl_->RenderGrid(renderer); }
std::optional<PresentPose> Mapper::FindPresentPose() const { return impl_->PoseNow(); }

}  // namespace enfilade::slam

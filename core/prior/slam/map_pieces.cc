// SPDX-License-Identifier: Apache-2.0
#include "core/prior/slam/map_pieces.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <utility>

#include "core/base/status_macros.h"
#include "core/slam/mapper/map_renderer.h"
#include "core/slam/submaps/robot_rays.h"
#include "core/slam/submaps/submap.h"
#include "fmt/format.h"

namespace enfilade::prior {
namespace {

constexpr double kPieceLength = 4.0;        // m, driven
constexpr std::size_t kMostKeyframes = 16;  // of a piece: turning on the spot

// The covariance of a pose in a submap, seen from a frame that is turned by `yaw` there.
Eigen::Matrix3d SeenFrom(double yaw, const Eigen::Matrix3d& information) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-yaw).toRotationMatrix();
  const Eigen::Matrix3d covariance = turn * information.inverse() * turn.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

class Cutter {
 public:
  Cutter(const slam::SlamMap& map, const std::vector<sensor::PairedScan>& scans, const slam::SlamOptions& options)
      : map_(map), options_(options) {
    for (const sensor::PairedScan& scan : scans) scan_of_[scan.sequence] = &scan;
  }

  absl::StatusOr<CutMap> Run() {
    for (const auto& [id, submap] : map_.submaps) {
      ENFILADE_ASSIGN_OR_RETURN(const slam::SubmapContent content,
                                slam::DecodeSubmapContent(submap.content, options_.occupancy));
      Cut(content);
      if (content.next) T_last_next_ = content.next->T_submap_next;
    }
    for (const auto& [id, closure] : map_.loop_closures) {
      if (closure.state == slam::LoopClosureState::kAccepted) AddClosure(closure);
    }
    slam::MapRenderer renderer(options_.resolution, slam::LogOddsOptionsOf(options_.occupancy));
    for (MapPiece& piece : cut_.pieces) piece.evidence = EvidenceOf(renderer.Render(&piece.grid, {}));
    return std::move(cut_);
  }

 private:
  void Cut(const slam::SubmapContent& content) {
    bool is_first = true;  // of the submap
    double length = 0;
    for (const slam::SubmapNode& node : content.nodes) {
      if (node.carried) continue;
      length += node.length;
      if (is_first || length > kPieceLength || cut_.pieces.back().nodes.size() >= kMostKeyframes) {
        Begin(node, is_first);
        length = 0;
      }
      is_first = false;
      Add(node);
    }
  }

  void Begin(const slam::SubmapNode& node, bool is_first) {
    if (!cut_.pieces.empty()) {
      // Of the piece before, in the submap of this one.
      const Pose2 T_submap_last = is_first ? Between(T_last_next_, T_submap_piece_) : T_submap_piece_;
      cut_.links.push_back({.from = cut_.pieces.size() - 1,
                            .to = cut_.pieces.size(),
                            .T_from_to = Between(T_submap_last, node.T_submap_node),
                            .covariance = SeenFrom(T_submap_last.yaw, node.information)});
    }
    T_submap_piece_ = node.T_submap_node;
    cut_.pieces.push_back({.id = MapId(fmt::format("piece-{}", cut_.pieces.size())),
                           .nodes = {},
                           .T_piece_node = {},
                           .T_map_piece = map_.nodes.at(node.node).T_map_node,
                           .grid = slam::SubmapGrid(options_.resolution, options_.occupancy),
                           .evidence = {}});
  }

  void Add(const slam::SubmapNode& node) {
    MapPiece& piece = cut_.pieces.back();
    piece.nodes.push_back(node.node);
    piece.T_piece_node.push_back(Between(T_submap_piece_, node.T_submap_node));
    piece_of_[node.node] = cut_.pieces.size() - 1;
    const auto scan = scan_of_.find(map_.nodes.at(node.node).sequence);
    if (scan == scan_of_.end()) return;
    // A scan that is absurdly far away has no walls here.
    piece.grid
        .Insert(piece.T_piece_node.back(),
                slam::RobotRays(scan->second->scan, {options_.max_range, options_.occupancy.no_return_range}))
        .IgnoreError();
  }

  // The keyframe was found among the walls of the submap, nearest to the piece whose keyframe is nearest.
  void AddClosure(const slam::LoopClosure& closure) {
    const Pose2 T_map_submap = map_.submaps.at(closure.submap).T_map_submap;
    std::int64_t nearest = -1;
    double least = 0;
    for (const auto& [id, node] : map_.nodes) {
      if (node.submap != closure.submap) continue;
      const double distance =
          (Between(T_map_submap, node.T_map_node).translation() - closure.T_submap_node.translation()).norm();
      if (nearest >= 0 && distance >= least) continue;
      nearest = id;
      least = distance;
    }
    if (nearest < 0) return;
    const std::size_t from = piece_of_.at(nearest);
    const std::size_t to = piece_of_.at(closure.node);
    if (from == to) return;
    const MapPiece& other = cut_.pieces[to];
    const Pose2 T_submap_from = Between(T_map_submap, cut_.pieces[from].T_map_piece);
    const std::size_t at =
        static_cast<std::size_t>(std::find(other.nodes.begin(), other.nodes.end(), closure.node) - other.nodes.begin());
    cut_.links.push_back({.from = from,
                          .to = to,
                          .T_from_to = Between(T_submap_from, closure.T_submap_node) * Inverse(other.T_piece_node[at]),
                          .covariance = SeenFrom(T_submap_from.yaw, closure.information),
                          .is_closure = true});
  }

  const slam::SlamMap& map_;
  const slam::SlamOptions& options_;
  std::map<std::int64_t, const sensor::PairedScan*> scan_of_;
  std::map<std::int64_t, std::size_t> piece_of_;  // by keyframe
  Pose2 T_submap_piece_;                          // of the last piece
  Pose2 T_last_next_;                             // of the last submap
  CutMap cut_;
};

}  // namespace

absl::StatusOr<CutMap> CutIntoPieces(const slam::SlamMap& map, const std::vector<sensor::PairedScan>& scans,
                                     const slam::SlamOptions& options) {
  return Cutter(map, scans, options).Run();
}

slam::SlamMap WithPieces(slam::SlamMap map, const std::vector<MapPiece>& pieces,
                         const std::vector<Pose2>& T_map_pieces) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (std::size_t k = 0; k < pieces[i].nodes.size(); ++k) {
      map.nodes.at(pieces[i].nodes[k]).T_map_node = T_map_pieces[i] * pieces[i].T_piece_node[k];
    }
  }
  return map;
}

grid::OccupancyGrid RenderPieces(const std::vector<MapPiece>& pieces, const std::vector<Pose2>& T_map_pieces,
                                 const slam::SlamOptions& options) {
  slam::MapRenderer renderer(options.resolution, slam::LogOddsOptionsOf(options.occupancy));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    renderer.Place(static_cast<std::int64_t>(i), T_map_pieces[i],
                   [&]() -> const slam::SubmapGrid& { return pieces[i].grid; });
  }
  return renderer.Render(nullptr, {});
}

}  // namespace enfilade::prior

// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/finished_submap.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace enfilade::slam {
namespace {

Eigen::AlignedBox2d KnownBox(const SubmapGrid& grid) {
  const grid::LogOddsGrid& cells = grid.log_odds();
  Eigen::AlignedBox2d box;
  if (cells.cells().empty()) return box;
  const Eigen::Vector2d min(cells.window_min().column, cells.window_min().row);
  box.extend(cells.resolution() * min);
  box.extend(cells.resolution() * (min + Eigen::Vector2d(cells.width(), cells.height())));
  return box;
}

}  // namespace

FinishedSubmap FinishSubmap(const Pose2& T_map_submap, std::int64_t version, std::string content,
                            const std::vector<SubmapNode>& nodes, const std::optional<NextSubmap>& next) {
  FinishedSubmap submap{T_map_submap, version, std::move(content), nodes, next, 0.0, 0.0, {}};
  for (const SubmapNode& node : nodes) {
    if (!node.carried) submap.length += node.length;
    submap.extent = std::max(submap.extent, node.T_submap_node.translation().norm());
  }
  return submap;
}

FinishedSubmap FinishExistingMap(std::int64_t version, const SubmapContent& content) {
  FinishedSubmap submap = FinishSubmap({}, version, Encode(content), {}, content.next);
  submap.known = KnownBox(content.grid);
  return submap;
}

absl::StatusOr<FinishedSubmap> RestoreFinishedSubmap(const SlamSubmap& row, const OccupancyOptions& options) {
  absl::StatusOr<SubmapContent> content = DecodeSubmapContent(row.content, options);
  if (!content.ok()) return WithContext(content.status(), fmt::format("stored submap {}", row.id));
  FinishedSubmap submap = FinishSubmap(row.T_map_submap, row.version, row.content, content->nodes, content->next);
  if (content->nodes.empty()) submap.known = KnownBox(content->grid);
  return submap;
}

}  // namespace enfilade::slam

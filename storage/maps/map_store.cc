// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/map_store.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/resource_name.h"

namespace enfilade::storage {
namespace {

std::string Listing(const std::vector<std::string>& ids) {
  constexpr std::size_t kShown = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(ids.size(), kShown); ++i) text += (i > 0 ? ", " : "") + ids[i];
  if (ids.size() > kShown) text += fmt::format(" and {} more", ids.size() - kShown);
  return text;
}

}  // namespace

absl::Status ValidateOutline(const Map& map) {
  for (const Eigen::Vector2d& corner : map.outline) {
    if (!corner.allFinite()) return InvalidArgument("outline has a corner that is not finite");
  }
  if (!map.outline.empty() && map.outline.size() < 3) {
    return InvalidArgument("outline has {} corners: at least 3 are needed", map.outline.size());
  }
  return absl::OkStatus();
}

absl::Status ValidateUnused(const SiteId& site, const MapId& map, const MapUse& use) {
  std::string needed;
  if (!use.sessions.empty()) {
    needed = fmt::format("{} sessions map into it: {}", use.sessions.size(), Listing(use.sessions));
  }
  if (!use.link_points.empty()) {
    if (!needed.empty()) needed += "; ";
    needed += fmt::format("{} link points join it: {}", use.link_points.size(), Listing(use.link_points));
  }
  if (needed.empty()) return absl::OkStatus();
  return FailedPrecondition("{}: {}. Delete them first, or use force", NameOf(site, map), needed);
}

}  // namespace enfilade::storage

// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/link_point_rules.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/graph/same_place.h"

namespace enfilade::storage {
namespace {

// Anchors in known maps keep their order, new ones follow.
std::vector<graph::Anchor> MergeAnchors(const graph::LinkPoint& stored, const std::vector<graph::Anchor>& anchors) {
  std::vector<graph::Anchor> merged;
  for (const graph::Anchor& before : stored.anchors) {
    for (const graph::Anchor& anchor : anchors) {
      if (anchor.map == before.map) merged.push_back(anchor);
    }
  }
  for (const graph::Anchor& anchor : anchors) {
    if (!stored.FindAnchor(anchor.map)) merged.push_back(anchor);
  }
  return merged;
}

}  // namespace

AnchorChange CompareAnchors(const std::vector<graph::Anchor>& before, const std::vector<graph::Anchor>& after) {
  AnchorChange change = AnchorChange::kNone;
  for (const graph::Anchor& anchor : after) {
    const auto same = std::find_if(before.begin(), before.end(),
                                   [&](const graph::Anchor& stored) { return stored.map == anchor.map; });
    if (same == before.end()) return AnchorChange::kAdded;
    if (*same != anchor) change = AnchorChange::kMoved;
  }
  return change;
}

absl::Status CheckNotRedundant(const StoredLinkPoint& changed, AnchorChange change,
                               const std::vector<StoredLinkPoint>& others) {
  const graph::LinkPoint& point = changed.point;
  if (change == AnchorChange::kNone || changed.forced || point.use == graph::LinkPointUse::kSuspended) {
    return absl::OkStatus();
  }
  const StoredLinkPoint* nearest = nullptr;
  std::optional<graph::CommonPlace> common;
  for (const StoredLinkPoint& other : others) {
    if (other.point.id == point.id || other.point.use == graph::LinkPointUse::kSuspended) continue;
    if (other.forced && change != AnchorChange::kAdded) continue;
    const std::optional<graph::CommonPlace> place = graph::FindCommonPlace(point.anchors, other.point.anchors);
    if (!place || (common && common->distance <= place->distance)) continue;
    nearest = &other;
    common = place;
  }
  if (nearest == nullptr) return absl::OkStatus();
  return AlreadyExists(
      "{}: it joins the same {} maps at the same place as {}, {:.2f} m apart. Use force if there really are two",
      NameOf(changed.site, point.id), common->map_count, NameOf(changed.site, nearest->point.id), common->distance);
}

absl::StatusOr<StoredLinkPoint> ApplyUpdate(const StoredLinkPoint& stored, const StoredLinkPoint& update,
                                            const std::vector<StoredLinkPoint>& others) {
  StoredLinkPoint changed = update;
  changed.point.use = stored.point.use;
  changed.T_world_place = stored.T_world_place;
  changed.create_time = stored.create_time;
  if (stored.forced && !changed.forced) {
    changed.point.anchors = stored.point.anchors;
    ENFILADE_RETURN_IF_ERROR(CheckNotRedundant(changed, AnchorChange::kMoved, others));
  }
  changed.point.anchors = MergeAnchors(stored.point, update.point.anchors);
  ENFILADE_RETURN_IF_ERROR(
      CheckNotRedundant(changed, CompareAnchors(stored.point.anchors, changed.point.anchors), others));
  return changed;
}

absl::StatusOr<StoredLinkPoint> ApplyAnchor(const StoredLinkPoint& stored, const NewAnchor& added,
                                            const std::vector<StoredLinkPoint>& others) {
  if (stored.point.FindAnchor(added.anchor.map)) {
    return AlreadyExists("{} already has an anchor in the map \"{}\": update it instead",
                         NameOf(stored.site, stored.point.id), added.anchor.map.value());
  }
  StoredLinkPoint changed = stored;
  changed.point.anchors.push_back(added.anchor);
  changed.forced = stored.forced || added.force;
  ENFILADE_RETURN_IF_ERROR(CheckNotRedundant(changed, AnchorChange::kAdded, others));
  return changed;
}

absl::StatusOr<StoredLinkPoint> ApplySuspension(const StoredLinkPoint& stored, bool suspended,
                                                const std::vector<StoredLinkPoint>& others) {
  StoredLinkPoint changed = stored;
  changed.point.use = suspended ? graph::LinkPointUse::kSuspended : graph::LinkPointUse::kUsed;
  const bool resumed = !suspended && stored.point.use == graph::LinkPointUse::kSuspended;
  ENFILADE_RETURN_IF_ERROR(CheckNotRedundant(changed, resumed ? AnchorChange::kMoved : AnchorChange::kNone, others));
  return changed;
}

}  // namespace enfilade::storage

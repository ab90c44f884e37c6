// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_preview.h"

#include <map>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/graph/graph_optimization.h"
#include "storage/etag.h"
#include "storage/graph/link_point_rules.h"

namespace enfilade::server {
namespace {

// A graph's link points while changes are made to a copy of them, by the rules of the stores.
class ChangedGraph {
 public:
  ChangedGraph(const SiteId& site, const SiteGraph& graph) : site_(site), graph_(graph) {}

  absl::Status Make(const storage::LinkPointChange& change) {
    return std::visit([this](const auto& one) { return MakeOne(one); }, change);
  }

  absl::StatusOr<graph::GraphSnapshot> Snapshot() const {
    graph::SnapshotChanges changes{.version = graph_.graph().version()};
    for (const auto& [id, link_point] : changed_) {
      if (link_point) {
        changes.link_points.push_back(link_point->point);
      } else {
        changes.removed_link_points.push_back(id);
      }
    }
    return graph::Apply(graph_.graph(), changes);
  }

 private:
  const storage::StoredLinkPoint* Find(const LinkPointId& id) const {
    const auto changed = changed_.find(id);
    if (changed != changed_.end()) return changed->second ? &*changed->second : nullptr;
    const int slot = graph_.graph().LinkPointSlot(id);
    return slot < 0 ? nullptr : &graph_.placed.Get(slot);
  }

  absl::StatusOr<const storage::StoredLinkPoint*> Get(const LinkPointId& id, std::int64_t etag) const {
    const storage::StoredLinkPoint* const stored = Find(id);
    if (stored == nullptr) return NotFound("{} does not exist", NameOf(site_, id));
    if (etag != 0 && etag != stored->etag) return storage::StaleEtag(NameOf(site_, id));
    return stored;
  }

  // Those with an anchor in one of the maps of `anchors`.
  std::vector<storage::StoredLinkPoint> Beside(const std::vector<graph::Anchor>& anchors) const {
    std::map<LinkPointId, const storage::StoredLinkPoint*> found;
    for (const graph::Anchor& anchor : anchors) {
      for (const graph::LinkPoint* link_point : graph_.graph().ListLinkPointsIn(anchor.map)) {
        found[link_point->id] = Find(link_point->id);
      }
    }
    for (const auto& [id, link_point] : changed_) found[id] = Find(id);
    std::vector<storage::StoredLinkPoint> beside;
    for (const auto& [id, link_point] : found) {
      if (link_point != nullptr) beside.push_back(*link_point);
    }
    return beside;
  }

  absl::Status CheckMaps(const storage::StoredLinkPoint& link_point) const {
    for (const graph::Anchor& anchor : link_point.point.anchors) {
      if (graph_.graph().MapSlot(anchor.map) >= 0) continue;
      return NotFound("{}: one of its maps does not exist: {}", NameOf(site_, link_point.point.id), anchor.map.value());
    }
    return absl::OkStatus();
  }

  absl::Status MakeOne(const storage::LinkPointCreation& change) {
    storage::StoredLinkPoint created = change.link_point;
    ENFILADE_RETURN_IF_ERROR(storage::ValidateLinkPoint(created));
    if (Find(created.point.id) != nullptr) return AlreadyExists("{} exists already", NameOf(site_, created.point.id));
    ENFILADE_RETURN_IF_ERROR(CheckMaps(created));
    created.point.use = graph::LinkPointUse::kUsed;
    ENFILADE_RETURN_IF_ERROR(
        storage::CheckNotRedundant(created, storage::AnchorChange::kAdded, Beside(created.point.anchors)));
    changed_[created.point.id] = std::move(created);
    return absl::OkStatus();
  }

  absl::Status MakeOne(const storage::LinkPointUpdate& change) {
    const storage::StoredLinkPoint& update = change.link_point;
    ENFILADE_RETURN_IF_ERROR(storage::ValidateLinkPoint(update));
    ENFILADE_ASSIGN_OR_RETURN(const storage::StoredLinkPoint* const stored, Get(update.point.id, update.etag));
    ENFILADE_RETURN_IF_ERROR(CheckMaps(update));
    ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint changed,
                              storage::ApplyUpdate(*stored, update, Beside(update.point.anchors)));
    changed_[update.point.id] = std::move(changed);
    return absl::OkStatus();
  }

  absl::Status MakeOne(const storage::LinkPointSuspension& change) {
    ENFILADE_ASSIGN_OR_RETURN(const storage::StoredLinkPoint* const stored, Get(change.link_point, change.etag));
    ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint changed,
                              storage::ApplySuspension(*stored, change.suspended, Beside(stored->point.anchors)));
    changed_[change.link_point] = std::move(changed);
    return absl::OkStatus();
  }

  absl::Status MakeOne(const storage::LinkPointDeletion& change) {
    ENFILADE_RETURN_IF_ERROR(Get(change.link_point, change.etag).status());
    changed_[change.link_point] = std::nullopt;
    return absl::OkStatus();
  }

  const SiteId& site_;
  const SiteGraph& graph_;
  std::map<LinkPointId, std::optional<storage::StoredLinkPoint>> changed_;  // unset: deleted
};

}  // namespace

absl::StatusOr<graph::GraphSnapshot> WithChanges(const SiteId& site, const SiteGraph& graph,
                                                 const std::vector<storage::LinkPointChange>& changes) {
  if (changes.empty()) return InvalidArgument("changes is empty: expected at least one change");
  ChangedGraph changed(site, graph);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    ENFILADE_RETURN_IF_ERROR(WithContext(changed.Make(changes[i]), fmt::format("changes[{}]", i)));
  }
  return changed.Snapshot();
}

absl::StatusOr<GraphPreview> PreviewChanges(const SiteId& site, const SiteGraph& graph,
                                            std::shared_ptr<const graph::SolvedGraph> before,
                                            const std::vector<storage::LinkPointChange>& changes) {
  ENFILADE_ASSIGN_OR_RETURN(const graph::GraphSnapshot changed, WithChanges(site, graph, changes));
  ENFILADE_ASSIGN_OR_RETURN(graph::SolvedGraph solved, graph::OptimizeGraph(changed));
  GraphPreview preview{std::move(before), std::make_shared<const graph::SolvedGraph>(std::move(solved)), {}};
  std::vector<LinkPointId> asked;
  for (const storage::LinkPointChange& change : changes) asked.push_back(storage::LinkPointOf(change));
  ENFILADE_ASSIGN_OR_RETURN(preview.difference,
                            graph::CompareSolutions({graph.graph(), preview.before}, {changed, preview.after}, asked));
  return preview;
}

}  // namespace enfilade::server

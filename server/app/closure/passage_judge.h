#pragma once

#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/joined_anchors.h"
#include "core/closure/judge_passage.h"
#include "core/closure/known_places.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/place_comparison.h"
#include "server/app/closure/session_scene.h"
#include "server/app/closure/stored_views.h"
#include "server/app/graph/site_graph.h"

namespace enfilade::server {

// What a passage is judged from.
struct PassageScene {
  const ClosureStores& stores;
  const ClosureOptions& options;
  const SiteGraph& graph;
  const SessionScene& scene;
  const DoorReport& report;
  const Map& map;                  // that the session is in
  PoseWithCovariance T_map_door;   // in it
  PoseWithCovariance T_map_robot;  // when it reports
  std::set<LinkPointId> excluded;  // not to be promoted
  std::function<absl::Status()> go_on;
};

// Judges a passage: a link point of the map itself, one that images and clouds tell of, or a new one. Fills in all of
// `change` but what belongs to the report: session, sequence and graph version. Errors are the stores'.
absl::Status JudgePassage(const CallContext& context, const PassageScene& passage, StoredViews& views,
                          DoorChange& change);

// What the session saw from `map` at `time`, as evidence for an anchor: up to images_kept images of each camera and the
// nearest cloud, all within [from, to]. Adds the records to `seen`.
std::vector<Evidence> EvidenceAt(const SessionScene& scene, const LinkPointId& link_point, const MapId& map,
                                 TimeNs time, TimeNs from, TimeNs to,
                                 const std::function<std::optional<Pose2>(TimeNs)>& T_map_robot,
                                 const ClosureOptions& options, std::vector<std::int64_t>& seen);

}  // namespace enfilade::server

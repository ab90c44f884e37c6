// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <set>

#include "absl/status/status.h"
#include "core/closure/closure_options.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/session_scene.h"
#include "server/app/graph/site_graph.h"

namespace enfilade::server {

// What a passage is judged from.
struct PassageScene {
  const DoorClosureStores& stores;
  const closure::DoorClosureOptions& options;
  const SiteGraph& graph;
  const SessionScene& scene;
  const sensor::DoorReport& report;
  const storage::Map& map;         // that the session is in
  PoseWithCovariance T_map_door;   // in it
  PoseWithCovariance T_map_robot;  // when it reports
  std::set<LinkPointId> excluded;  // not to be promoted
  double waited;                   // s, for maps that others are in the middle of mapping
  std::function<absl::Status()> go_on;
};

}  // namespace enfilade::server

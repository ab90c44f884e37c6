// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/graph/global_pose.h"
#include "core/graph/paths/routes.h"
#include "enfilade/v1/graph.pb.h"
#include "server/app/graph/graph_page.h"
#include "server/app/graph/site_graph.h"
#include "storage/graph/graph_store.h"

namespace enfilade::server {

// Values of the graph as the API's messages, resource names within `site`.

// What all pages of a graph have, and the items of this one.
v1::Graph ToProto(const SiteId& site, const SiteGraph& graph, const GraphPage& page);
// The whole.
v1::Graph ToProto(const SiteId& site, const SiteGraph& graph);
// A map and a link point of it, with their places in the world (unset: none).
void Fill(const SiteId& site, const graph::MapInGraph& map, const std::optional<PoseWithCovariance>& T_world_map,
          bool optimized, v1::GraphMap& out);
void Fill(const SiteId& site, const graph::LinkPoint& link_point,
          const std::optional<PoseWithCovariance>& T_world_place, v1::GraphLinkPoint& out);
v1::GraphVersion ToProto(const SiteId& site, const storage::GraphVersion& version);
v1::PoseHop ToProto(const SiteId& site, const graph::PoseHop& hop);
// All of GlobalPose but robot, map_pose and report_time.
void Fill(const SiteId& site, const graph::GlobalPose& pose, v1::GlobalPose& out);
v1::Route ToProto(const SiteId& site, const graph::Route& route);
v1::Georeference ToProto(const SiteId& site, const SiteGraph& graph, const geo::GeoreferenceFit& fit,
                         const std::vector<storage::ControlPoint>& points);

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/export_graph.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/graph/geojson.h"
#include "proto/convert/names.h"
#include "server/app/graph/graph_page.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kChunkBytes = 1 << 20;
// The text is made as a whole: some 30 MB.
constexpr std::size_t kMaxEdges = 100'000;
constexpr int kMaxTracks = 1000;
// Between points of a track, m: scans are closer together than a picture shows.
constexpr double kTrackStep = 0.25;

std::vector<Eigen::Vector2d> Thinned(const std::vector<slam::StampedPose>& poses) {
  std::vector<Eigen::Vector2d> points;
  for (const slam::StampedPose& pose : poses) {
    const Eigen::Vector2d p_map = pose.T_map_robot.translation();
    const bool is_last = &pose == &poses.back() && (points.empty() || points.back() != p_map);
    if (points.empty() || is_last || (p_map - points.back()).norm() >= kTrackStep) points.push_back(p_map);
  }
  return points;
}

absl::StatusOr<std::vector<graph::Track>> ReadTracks(const Services& services, const Call& call, const SiteId& site) {
  std::vector<graph::Track> tracks;
  ENFILADE_ASSIGN_OR_RETURN(const auto sessions,
                            services.sessions.List(call.context(), site, {}, kMaxTracks, std::nullopt));
  for (const storage::Session& session : sessions) {
    if (!session.map || session.mapped_sequence == 0) continue;
    const auto trajectory = services.mappings.ReadTrajectory(call.context(), site, session.id);
    if (absl::IsNotFound(trajectory.status())) continue;  // deleted meanwhile
    ENFILADE_RETURN_IF_ERROR(trajectory.status());
    graph::Track track{session.id, session.robot, *session.map, Thinned(trajectory->poses)};
    if (track.p_map.size() >= 2) tracks.push_back(std::move(track));
  }
  return tracks;
}

}  // namespace

absl::StatusOr<MessageSource<v1::ExportGraphResponse>> ExportGraph(const Services& services, const Call& call,
                                                                   const v1::ExportGraphRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), site));
  if (const std::size_t edges = CountEdges(graph->graph()); edges > kMaxEdges && !request.without_edges()) {
    return ResourceExhausted("the graph has {} edges, more than {}: set without_edges", edges, kMaxEdges);
  }
  std::vector<graph::Track> tracks;
  if (request.with_tracks()) {
    ENFILADE_ASSIGN_OR_RETURN(tracks, ReadTracks(services, call, site));
  }
  const auto text = std::make_shared<const std::string>(graph::GraphToGeoJson(
      graph->poses, graph->georeference.has_value() ? &graph->georeference->georeference : nullptr,
      !request.without_edges(), tracks));
  const std::int64_t version = graph->graph().version();
  return [text, version, begun = false,
          offset = std::size_t{0}](v1::ExportGraphResponse& message) mutable -> absl::StatusOr<bool> {
    if (!begun) {
      begun = true;
      message.mutable_manifest()->set_graph_version(version);
      v1::FileEntry& file = *message.mutable_manifest()->add_files();
      file.set_name("graph.geojson");
      file.set_size_bytes(static_cast<std::int64_t>(text->size()));
      file.set_sha256(Sha256(*text));
      return true;
    }
    if (offset == text->size()) return false;
    v1::FileChunk& chunk = *message.mutable_chunk();
    chunk.set_file(0);
    chunk.set_offset(static_cast<std::int64_t>(offset));
    const std::size_t size = std::min(kChunkBytes, text->size() - offset);
    chunk.set_data(text->substr(offset, size));
    offset += size;
    return true;
  };
}

}  // namespace enfilade::server

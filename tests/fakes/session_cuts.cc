// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

using Records = std::map<std::int64_t, RecordRow>;

// What the counters of a session say of its log.
void Count(const Records& records, storage::Session& session) {
  storage::RecordCounts counts;
  session.payload_bytes = 0;
  session.first_time = session.last_time = std::nullopt;
  for (const auto& [sequence, row] : records) {
    session.payload_bytes += static_cast<std::int64_t>(row.payload.size());
    counts.laser_scans += row.kind == sensor::RecordKind::kLaserScan;
    counts.odometry += row.kind == sensor::RecordKind::kOdometry;
    counts.images += row.kind == sensor::RecordKind::kImage;
    counts.point_clouds += row.kind == sensor::RecordKind::kPointCloud;
    counts.withheld += row.kind == sensor::RecordKind::kWithheld;
    counts.door_reports += row.kind == sensor::RecordKind::kDoorReport;
    if (row.kind == sensor::RecordKind::kWithheld) continue;
    session.first_time = std::min(session.first_time.value_or(row.time), row.time);
    session.last_time = std::max(session.last_time.value_or(row.time), row.time);
  }
  session.record_counts = counts;
}

// The part of the map that the scans of some records have made: its keyframes, their submaps, the closures between
// them. The submaps of an existing map, which have no keyframes at all, stay with the first part.
template <typename IsOfPart>
slam::SlamMap PartOf(const slam::SlamMap& map, bool is_first, const IsOfPart& is_of_part) {
  slam::SlamMap part = map;
  std::set<std::int64_t> used, kept;
  for (const auto& [id, node] : map.nodes) {
    used.insert(node.submap);
    if (is_of_part(node.sequence)) kept.insert(node.submap);
  }
  std::erase_if(part.nodes, [&](const auto& entry) { return !is_of_part(entry.second.sequence); });
  std::erase_if(part.submaps, [&](const auto& entry) {
    return !kept.contains(entry.first) && (!is_first || used.contains(entry.first));
  });
  std::erase_if(part.trajectory, [&](const slam::TrajectoryPoint& point) { return !is_of_part(point.sequence); });
  std::erase_if(part.loop_closures, [&](const auto& entry) {
    return !part.nodes.contains(entry.second.node) || !part.submaps.contains(entry.second.submap);
  });
  return part;
}

storage::MappingCounts CountsOf(const slam::SlamMap& map) {
  storage::MappingCounts counts;
  counts.used = static_cast<std::int64_t>(map.trajectory.size());
  counts.keyframes = static_cast<std::int64_t>(map.nodes.size());
  return counts;
}

// The passage into the next session is at the end of the log.
void Follow(SiteRows& site, const SessionId& from, const SessionId& to) {
  for (auto& [id, row] : site.sessions) {
    if (id != to && row.session.entry.previous == from) row.session.entry.previous = to;
  }
  for (auto& [robot, pose] : site.robot_poses) {
    if (pose.session == from) pose.session = to;
  }
}

SessionRow RestOf(const SessionRow& whole, const rearrange::SessionCut& cut) {
  SessionRow rest = whole;
  rest.request_id = {};
  rest.lease = {};
  rest.session.id = cut.rest;
  rest.session.entry = {};
  rest.session.entry.previous = cut.session;
  rest.session.surveyed = false;
  const std::int64_t skipped = whole.cut_from ? whole.records.begin()->first - 1 : 0;
  rest.session.create_time += 1000 * (cut.first_sequence - skipped);
  rest.cut_from = whole.cut_from.value_or(cut.session);
  rest.recorded_sequence = whole.session.highest_sequence;
  rest.records.erase(rest.records.begin(), rest.records.lower_bound(cut.first_sequence));
  Count(rest.records, rest.session);
  if (!rest.mapping) return rest;
  rest.mapping->map =
      PartOf(whole.mapping->map, false, [&](std::int64_t sequence) { return sequence >= cut.first_sequence; });
  rest.mapping->checkpoint.clear();
  rest.counts = CountsOf(rest.mapping->map);
  return rest;
}

void CutSession(SiteRows& site, const rearrange::SessionCut& cut) {
  SessionRow& head = site.sessions.at(cut.session);
  SessionRow rest = RestOf(head, cut);
  head.recorded_sequence = head.recorded_sequence.value_or(head.session.highest_sequence);
  head.records.erase(head.records.lower_bound(cut.first_sequence), head.records.end());
  head.session.acknowledged_sequence = head.session.highest_sequence = cut.first_sequence - 1;
  Count(head.records, head.session);
  if (head.mapping) {
    head.mapping->map =
        PartOf(head.mapping->map, true, [&](std::int64_t sequence) { return sequence < cut.first_sequence; });
    head.mapping->mapped_sequence = cut.first_sequence - 1;
    const storage::MappingCounts counts = CountsOf(head.mapping->map);
    head.counts.used = counts.used;
    head.counts.keyframes = counts.keyframes;
  }
  Follow(site, cut.session, cut.rest);
  site.sessions.insert_or_assign(cut.rest, std::move(rest));
}

}  // namespace

void MoveSession(SessionRow& row, const rearrange::SessionMove& move) {
  row.session.map = move.to;
  if (auto& entry = row.session.entry.T_map_robot) entry = rearrange::Moved(move.T_to_from, *entry);
  if (!row.mapping) return;
  for (auto& [id, submap] : row.mapping->map.submaps) submap.T_map_submap = move.T_to_from * submap.T_map_submap;
  for (auto& [id, node] : row.mapping->map.nodes) {
    const PoseWithCovariance moved = rearrange::Moved(move.T_to_from, {node.T_map_node, node.covariance});
    node.T_map_node = moved.pose;
    node.covariance = moved.covariance;
  }
}

void CutSessions(SiteRows& site, std::vector<rearrange::SessionCut> cuts) {
  // The last one of each session first.
  std::sort(cuts.begin(), cuts.end(), [](const auto& a, const auto& b) { return a.first_sequence > b.first_sequence; });
  for (const rearrange::SessionCut& cut : cuts) CutSession(site, cut);
}

void UncutSession(SiteRows& site, const rearrange::SessionCut& cut, const SessionRow& before) {
  SessionRow& rest = site.sessions.at(cut.rest);
  SessionRow& head = site.sessions.at(cut.session);
  head.records.merge(rest.records);
  head.mapping = before.mapping;
  head.counts = before.counts;
  head.recorded_sequence = before.recorded_sequence;
  storage::Session& session = head.session;
  session.acknowledged_sequence = before.session.acknowledged_sequence;
  session.highest_sequence = before.session.highest_sequence;
  session.record_counts = before.session.record_counts;
  session.payload_bytes = before.session.payload_bytes;
  session.last_time = before.session.last_time;
  Follow(site, cut.rest, cut.session);
  DeleteSession(rest);
}

}  // namespace enfilade::testing

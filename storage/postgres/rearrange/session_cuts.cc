// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/session_cuts.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string_view>
#include <vector>

#include "storage/postgres/driver/params.h"

namespace enfilade::storage::postgres {
namespace {

// The cuts of a rearrangement: session c.subject, its rest c.target from record c.first_sequence on.
#define ENFILADE_ALL_CUTS \
  "enfilade.rearrangement_parts c WHERE c.site_id = $1 AND c.rearrangement_id = $2 AND c.kind = 2"
// Those whose rests are among $3.
#define ENFILADE_THESE " AND c.target = ANY ($3)"
#define ENFILADE_CUTS ENFILADE_ALL_CUTS ENFILADE_THESE
#define ENFILADE_JOIN_CUTS(table)                                                                             \
  " FROM enfilade.rearrangement_parts c JOIN enfilade." table                                                 \
  " t ON t.site_id = c.site_id AND t.session_id = c.subject WHERE c.site_id = $1 AND c.rearrangement_id = $2" \
  " AND c.kind = 2" ENFILADE_THESE
#define ENFILADE_JOIN_RESTS(table)                                                                           \
  " FROM enfilade.rearrangement_parts c JOIN enfilade." table                                                \
  " t ON t.site_id = c.site_id AND t.session_id = c.target WHERE c.site_id = $1 AND c.rearrangement_id = $2" \
  " AND c.kind = 2"
#define ENFILADE_SUBMAP_VALUES "t.submap_id, t.version, t.x, t.y, t.yaw, t.finished, t.content"
#define ENFILADE_NODE_VALUES "t.node_id, t.sequence, t.time_ns, t.x, t.y, t.yaw, t.covariance, t.submap_id"
#define ENFILADE_POINT_VALUES "t.sequence, t.time_ns, t.node_id, t.x, t.y, t.yaw"
#define ENFILADE_CLOSURE_VALUES \
  "t.closure_id, t.submap_id, t.node_id, t.x, t.y, t.yaw, t.information, t.state, t.score, t.chi2, t.reason"
#define ENFILADE_VERDICT_VALUES                                                                           \
  "t.sequence, t.decision, t.link_point_id, t.map_id, t.x, t.y, t.yaw, t.covariance, t.odom_x, t.odom_y," \
  " t.odom_yaw, t.evidence, t.reason, t.graph_version, t.create_time"
#define ENFILADE_SUBMAP_COLUMNS "(site_id, session_id, submap_id, version, x, y, yaw, finished, content)"
#define ENFILADE_NODE_COLUMNS "(site_id, session_id, node_id, sequence, time_ns, x, y, yaw, covariance, submap_id)"
#define ENFILADE_POINT_COLUMNS "(site_id, session_id, sequence, time_ns, node_id, x, y, yaw)"
#define ENFILADE_CLOSURE_COLUMNS \
  "(site_id, session_id, closure_id, submap_id, node_id, x, y, yaw, information, state, score, chi2, reason)"
#define ENFILADE_CUT_VERDICT_COLUMNS                                                                        \
  "(site_id, session_id, sequence, decision, link_point_id, map_id, x, y, yaw, covariance, odom_x, odom_y," \
  " odom_yaw, evidence, reason, graph_version, create_time)"

// The kinds of records are those of core/sensor/record.h.
constexpr Statement kInsertRest{
    "making the rest of a session",
    "INSERT INTO enfilade.sessions (site_id, session_id, robot_id, map_id, state, acknowledged_sequence,"
    " highest_sequence, laser_scans, odometry, images, point_clouds, withheld, door_reports, payload_bytes,"
    " first_time_ns, last_time_ns, create_time, finish_time, previous_session_id, doors_judged, cut_from_session_id,"
    " recorded_sequence, skipped_records)"
    " SELECT t.site_id, c.target, t.robot_id, t.map_id, t.state, t.acknowledged_sequence, t.highest_sequence, n.scans,"
    "   n.odometry, n.images, n.clouds, n.withheld, n.doors, n.bytes, n.first_time, n.last_time,"
    "   t.create_time + (c.first_sequence - t.skipped_records) * interval '1 microsecond', t.finish_time, "
    "t.session_id, t.doors_judged,"
    "   coalesce(t.cut_from_session_id, t.session_id), t.highest_sequence, c.first_sequence - 1"
    " FROM enfilade.rearrangement_parts c JOIN enfilade.sessions t ON t.site_id = c.site_id AND t.session_id = "
    "c.subject"
    " CROSS JOIN LATERAL (SELECT count(*) FILTER (WHERE kind = 1) AS scans, count(*) FILTER (WHERE kind = 2) AS "
    "odometry,"
    "   count(*) FILTER (WHERE kind = 3) AS images, count(*) FILTER (WHERE kind = 4) AS clouds,"
    "   count(*) FILTER (WHERE kind = 5) AS withheld, count(*) FILTER (WHERE kind = 6) AS doors,"
    "   coalesce(sum(octet_length(payload)), 0) AS bytes, min(time_ns) FILTER (WHERE kind <> 5) AS first_time,"
    "   max(time_ns) FILTER (WHERE kind <> 5) AS last_time FROM enfilade.session_records r"
    "   WHERE r.site_id = c.site_id AND r.session_id = c.subject AND r.sequence >= c.first_sequence) n"
    " WHERE c.site_id = $1 AND c.rearrangement_id = $2 AND c.kind = 2" ENFILADE_THESE};
constexpr Statement kShrinkHead{
    "cutting the session",
    "UPDATE enfilade.sessions s SET acknowledged_sequence = c.first_sequence - 1,"
    " highest_sequence = c.first_sequence - 1, recorded_sequence = coalesce(s.recorded_sequence, s.highest_sequence),"
    " laser_scans = s.laser_scans - t.laser_scans, odometry = s.odometry - t.odometry, images = s.images - t.images,"
    " point_clouds = s.point_clouds - t.point_clouds, withheld = s.withheld - t.withheld,"
    " door_reports = s.door_reports - t.door_reports, payload_bytes = greatest(0, s.payload_bytes - t.payload_bytes),"
    " last_time_ns = (SELECT max(r.time_ns) FILTER (WHERE kind <> 5) FROM enfilade.session_records r"
    "   WHERE r.site_id = s.site_id AND r.session_id = s.session_id AND r.sequence < "
    "c.first_sequence)" ENFILADE_JOIN_RESTS("sessions") ENFILADE_THESE
    " AND s.site_id = $1 AND s.session_id = c.subject"};
constexpr Statement kCutRecords{"moving records",
                                "UPDATE enfilade.session_records r SET session_id = c.target FROM " ENFILADE_CUTS
                                " AND r.site_id = $1 AND r.session_id = c.subject AND r.sequence >= c.first_sequence"};
constexpr Statement kCutRecordBlobs{
    "moving records' blobs", "UPDATE enfilade.session_record_blobs r SET session_id = c.target FROM " ENFILADE_CUTS
                             " AND r.site_id = $1 AND r.session_id = c.subject AND r.sequence >= c.first_sequence"};
constexpr Statement kCopySubmaps{
    "copying submaps",
    "INSERT INTO enfilade.slam_submaps " ENFILADE_SUBMAP_COLUMNS " SELECT t.site_id, c.target, " ENFILADE_SUBMAP_VALUES
        ENFILADE_JOIN_CUTS("slam_submaps")
    " AND EXISTS (SELECT FROM enfilade.slam_nodes n WHERE n.site_id = $1 AND n.session_id = c.subject"
    "   AND n.submap_id = t.submap_id AND n.sequence >= c.first_sequence)"};
constexpr Statement kCopyNodes{"copying keyframes",
                               "INSERT INTO enfilade.slam_nodes " ENFILADE_NODE_COLUMNS
                               " SELECT t.site_id, c.target, " ENFILADE_NODE_VALUES ENFILADE_JOIN_CUTS(
                                   "slam_nodes") " AND t.sequence >= c.first_sequence"};
constexpr Statement kCopyPoints{"copying the trajectory",
                                "INSERT INTO enfilade.trajectory_points " ENFILADE_POINT_COLUMNS
                                " SELECT t.site_id, c.target, " ENFILADE_POINT_VALUES ENFILADE_JOIN_CUTS(
                                    "trajectory_points") " AND t.sequence >= c.first_sequence"};
constexpr Statement kCopyClosures{
    "copying loop closures",
    "INSERT INTO enfilade.slam_closures " ENFILADE_CLOSURE_COLUMNS " SELECT t.site_id, c.target, " ENFILADE_CLOSURE_VALUES
        ENFILADE_JOIN_CUTS("slam_closures")
    " AND EXISTS (SELECT FROM enfilade.slam_nodes n WHERE n.site_id = $1 AND n.session_id = c.target"
    "   AND n.node_id = t.node_id)"
    " AND EXISTS (SELECT FROM enfilade.slam_submaps m WHERE m.site_id = $1 AND m.session_id = c.target"
    "   AND m.submap_id = t.submap_id)"};
// Also those across the cut.
constexpr Statement kDropClosures{
    "removing loop closures",
    "DELETE FROM enfilade.slam_closures t USING " ENFILADE_CUTS
    " AND t.site_id = $1 AND t.session_id = c.subject AND (EXISTS (SELECT FROM enfilade.slam_nodes n"
    "   WHERE n.site_id = $1 AND n.session_id = c.target AND n.node_id = t.node_id)"
    "  OR (EXISTS (SELECT FROM enfilade.slam_submaps m WHERE m.site_id = $1 AND m.session_id = c.target"
    "   AND m.submap_id = t.submap_id) AND NOT EXISTS (SELECT FROM enfilade.slam_nodes n WHERE n.site_id = $1"
    "   AND n.session_id = c.subject AND n.submap_id = t.submap_id AND n.sequence < c.first_sequence)))"};
constexpr Statement kDropPoints{"removing the rest's trajectory",
                                "DELETE FROM enfilade.trajectory_points t USING " ENFILADE_CUTS
                                " AND t.site_id = $1 AND t.session_id = c.subject AND t.sequence >= c.first_sequence"};
constexpr Statement kDropNodes{"removing the rest's keyframes",
                               "DELETE FROM enfilade.slam_nodes t USING " ENFILADE_CUTS
                               " AND t.site_id = $1 AND t.session_id = c.subject AND t.sequence >= c.first_sequence"};
constexpr Statement kDropSubmaps{
    "removing the rest's submaps",
    "DELETE FROM enfilade.slam_submaps t USING " ENFILADE_CUTS
    " AND t.site_id = $1 AND t.session_id = c.subject AND EXISTS (SELECT FROM enfilade.slam_submaps m"
    "   WHERE m.site_id = $1 AND m.session_id = c.target AND m.submap_id = t.submap_id)"
    " AND NOT EXISTS (SELECT FROM enfilade.slam_nodes n WHERE n.site_id = $1 AND n.session_id = c.subject"
    "   AND n.submap_id = t.submap_id)"};
constexpr Statement kCopyVerdicts{"copying verdicts",
                                  "INSERT INTO enfilade.door_verdicts " ENFILADE_CUT_VERDICT_COLUMNS
                                  " SELECT t.site_id, c.target, " ENFILADE_VERDICT_VALUES ENFILADE_JOIN_CUTS(
                                      "door_verdicts") " AND t.sequence >= c.first_sequence"};
constexpr Statement kCutComparisons{
    "moving comparisons", "UPDATE enfilade.door_comparisons t SET session_id = c.target FROM " ENFILADE_CUTS
                          " AND t.site_id = $1 AND t.session_id = c.subject AND t.sequence >= c.first_sequence"};
constexpr Statement kDropVerdicts{
    "removing the rest's verdicts",
    "DELETE FROM enfilade.door_verdicts t USING " ENFILADE_CUTS
    " AND t.site_id = $1 AND t.session_id = c.subject AND t.sequence >= c.first_sequence"};
// The passage is at the end of the log.
constexpr Statement kFollowRest{
    "linking the sessions that follow",
    "UPDATE enfilade.sessions t SET previous_session_id = c.target FROM " ENFILADE_CUTS
    " AND t.site_id = $1 AND t.previous_session_id = c.subject AND t.session_id <> c.target"};
constexpr Statement kCutTracks{
    "storing the tracks",
    "INSERT INTO enfilade.session_tracks (site_id, session_id, map_id, track)"
    " SELECT s.site_id, s.session_id, s.map_id, ST_MakeLine(ST_MakePointM(n.x, n.y, n.time_ns / 1e9) ORDER BY "
    "n.node_id)"
    " FROM enfilade.rearrangement_parts c JOIN enfilade.sessions s ON s.site_id = c.site_id"
    "   AND s.session_id IN (c.subject, c.target)"
    " JOIN enfilade.slam_nodes n ON n.site_id = s.site_id AND n.session_id = s.session_id"
    " WHERE c.site_id = $1 AND c.rearrangement_id = $2 AND c.kind = 2" ENFILADE_THESE
    " AND s.map_id IS NOT NULL"
    " GROUP BY s.site_id, s.session_id, s.map_id HAVING count(*) >= 2"
    " ON CONFLICT (site_id, session_id) DO UPDATE SET map_id = excluded.map_id, track = excluded.track"};
constexpr Statement kDropShortTracks{
    "removing tracks",
    "DELETE FROM enfilade.session_tracks t USING " ENFILADE_CUTS
    " AND t.site_id = $1 AND t.session_id = c.subject AND (SELECT count(*) FROM enfilade.slam_nodes n"
    "   WHERE n.site_id = $1 AND n.session_id = c.subject) < 2"};
constexpr Statement kInsertCheckpoints{
    "storing how far the rest is mapped",
    "INSERT INTO enfilade.mapping_checkpoints (site_id, session_id, mapped_sequence, token, paired, unpaired,"
    " time_reversed, used, keyframes, lost, state)"
    " SELECT t.site_id, c.target, t.mapped_sequence, t.token, 0, 0, 0,"
    "   (SELECT count(*) FROM enfilade.trajectory_points p WHERE p.site_id = $1 AND p.session_id = c.target),"
    "   (SELECT count(*) FROM enfilade.slam_nodes n WHERE n.site_id = $1 AND n.session_id = c.target), 0, "
    "''" ENFILADE_JOIN_CUTS("mapping_checkpoints")};
constexpr Statement kShrinkCheckpoints{
    "storing how far the session is mapped",
    "UPDATE enfilade.mapping_checkpoints t SET mapped_sequence = c.first_sequence - 1,"
    " used = (SELECT count(*) FROM enfilade.trajectory_points p WHERE p.site_id = $1 AND p.session_id = c.subject),"
    " keyframes = (SELECT count(*) FROM enfilade.slam_nodes n WHERE n.site_id = $1 AND n.session_id = c.subject)"
    " FROM " ENFILADE_CUTS " AND t.site_id = $1 AND t.session_id = c.subject"};
constexpr Statement kCutRobotPoses{"assigning robots' poses",
                                   "UPDATE enfilade.robot_poses t SET session_id = c.target FROM " ENFILADE_CUTS
                                   " AND t.site_id = $1 AND t.session_id = c.subject"};

constexpr Statement kReturnRecords{
    "moving records back", "UPDATE enfilade.session_records r SET session_id = c.subject FROM " ENFILADE_ALL_CUTS
                           " AND r.site_id = $1 AND r.session_id = c.target"};
constexpr Statement kReturnRecordBlobs{
    "moving records' blobs back",
    "UPDATE enfilade.session_record_blobs r SET session_id = c.subject FROM " ENFILADE_ALL_CUTS
    " AND r.site_id = $1 AND r.session_id = c.target"};
constexpr Statement kReturnSubmaps{"returning submaps",
                                   "INSERT INTO enfilade.slam_submaps " ENFILADE_SUBMAP_COLUMNS
                                   " SELECT t.site_id, c.subject, " ENFILADE_SUBMAP_VALUES ENFILADE_JOIN_RESTS(
                                       "slam_submaps") " ON CONFLICT DO NOTHING"};
constexpr Statement kReturnNodes{
    "returning keyframes", "INSERT INTO enfilade.slam_nodes " ENFILADE_NODE_COLUMNS
                           " SELECT t.site_id, c.subject, " ENFILADE_NODE_VALUES ENFILADE_JOIN_RESTS("slam_nodes")};
constexpr Statement kReturnPoints{
    "returning the trajectory",
    "INSERT INTO enfilade.trajectory_points " ENFILADE_POINT_COLUMNS
    " SELECT t.site_id, c.subject, " ENFILADE_POINT_VALUES ENFILADE_JOIN_RESTS("trajectory_points")};
// From the image, which has those across the cut, too.
constexpr Statement kReturnClosures{
    "returning loop closures",
    "INSERT INTO enfilade.slam_closures " ENFILADE_CLOSURE_COLUMNS
    " SELECT t.site_id, t.session_id, " ENFILADE_CLOSURE_VALUES
    " FROM enfilade.rearrangement_images r, jsonb_array_elements(nullif(r.before, 'null')) e,"
    "   jsonb_populate_record(NULL::enfilade.slam_closures, e) t WHERE r.site_id = $1 AND r.rearrangement_id = $2"
    " AND r.relation = 'closures' ON CONFLICT DO NOTHING"};
#define ENFILADE_DROP_OF_RESTS(table) \
  "DELETE FROM enfilade." table " t USING " ENFILADE_ALL_CUTS " AND t.site_id = $1 AND t.session_id = c.target"
constexpr Statement kDropRestClosures{"removing the rest's loop closures", ENFILADE_DROP_OF_RESTS("slam_closures")};
constexpr Statement kDropRestPoints{"removing the rest's trajectory", ENFILADE_DROP_OF_RESTS("trajectory_points")};
constexpr Statement kDropRestNodes{"removing the rest's keyframes", ENFILADE_DROP_OF_RESTS("slam_nodes")};
constexpr Statement kDropRestSubmaps{"removing the rest's submaps", ENFILADE_DROP_OF_RESTS("slam_submaps")};
constexpr Statement kDropRestTracks{"removing the rest's track", ENFILADE_DROP_OF_RESTS("session_tracks")};
constexpr Statement kDropRestCheckpoints{"removing the rest's checkpoint",
                                         ENFILADE_DROP_OF_RESTS("mapping_checkpoints")};
constexpr Statement kReturnVerdicts{
    "returning verdicts",
    "INSERT INTO enfilade.door_verdicts " ENFILADE_CUT_VERDICT_COLUMNS
    " SELECT t.site_id, c.subject, " ENFILADE_VERDICT_VALUES ENFILADE_JOIN_RESTS("door_verdicts")};
constexpr Statement kReturnComparisons{
    "returning comparisons", "UPDATE enfilade.door_comparisons t SET session_id = c.subject FROM " ENFILADE_ALL_CUTS
                             " AND t.site_id = $1 AND t.session_id = c.target"};
constexpr Statement kDropRestVerdicts{"removing the rest's verdicts", ENFILADE_DROP_OF_RESTS("door_verdicts")};
constexpr Statement kFollowHead{"linking the sessions that follow",
                                "UPDATE enfilade.sessions t SET previous_session_id = c.subject FROM " ENFILADE_ALL_CUTS
                                " AND t.site_id = $1 AND t.previous_session_id = c.target"};
constexpr Statement kReturnRestRobotPoses{
    "assigning robots' poses", "UPDATE enfilade.robot_poses t SET session_id = c.subject FROM " ENFILADE_ALL_CUTS
                               " AND t.site_id = $1 AND t.session_id = c.target"};
// Revisions name it: the row stays, as that of any deleted session.
constexpr Statement kCloseRests{"closing the rest",
                                "UPDATE enfilade.sessions t SET delete_time = now(), robot_id = NULL, map_id = NULL, "
                                "purged = true FROM " ENFILADE_ALL_CUTS
                                " AND t.site_id = $1 AND t.session_id = c.target"};

// The cuts in the order in which they are made: the last one of each session first, so that what has been cut off is
// done. Of each round the rests.
std::vector<std::vector<std::string_view>> RoundsOf(const std::vector<rearrange::SessionCut>& cuts) {
  std::map<SessionId, std::map<std::int64_t, std::string_view, std::greater<>>> by_session;
  for (const rearrange::SessionCut& cut : cuts) by_session[cut.session][cut.first_sequence] = cut.rest.value();
  std::vector<std::vector<std::string_view>> rounds;
  for (const auto& [session, rests] : by_session) {
    if (rounds.size() < rests.size()) rounds.resize(rests.size());
    auto round = rounds.begin();
    for (const auto& [first_sequence, rest] : rests) (round++)->push_back(rest);
  }
  return rounds;
}

void QueueRound(Transaction& transaction, const Params& key) {
  for (const Statement* statement :
       {&kInsertRest,        &kShrinkHead,        &kCutRecords,   &kCutRecordBlobs, &kCopySubmaps,     &kCopyNodes,
        &kCopyPoints,        &kCopyClosures,      &kDropClosures, &kDropPoints,     &kDropNodes,       &kDropSubmaps,
        &kCopyVerdicts,      &kCutComparisons,    &kDropVerdicts, &kFollowRest,     &kDropShortTracks, &kCutTracks,
        &kInsertCheckpoints, &kShrinkCheckpoints, &kCutRobotPoses}) {
    transaction.Queue(*statement, key);
  }
}

}  // namespace

void QueueCuts(Transaction& transaction, const SiteId& site, const RearrangementChange& change) {
  for (const std::vector<std::string_view>& rests : RoundsOf(change.rearrangement.cuts)) {
    QueueRound(transaction, Params(site, change.id, rests));
  }
}

void QueueUncuts(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id) {
  const Params key(site, id);
  for (const Statement* statement :
       {&kReturnRecords, &kReturnRecordBlobs, &kReturnSubmaps, &kReturnNodes, &kReturnPoints, &kReturnClosures,
        &kDropRestClosures, &kDropRestPoints, &kDropRestNodes, &kDropRestSubmaps, &kDropRestTracks,
        &kDropRestCheckpoints, &kReturnVerdicts, &kReturnComparisons, &kDropRestVerdicts, &kFollowHead,
        &kReturnRestRobotPoses, &kCloseRests}) {
    transaction.Queue(*statement, key);
  }
}

}  // namespace enfilade::storage::postgres

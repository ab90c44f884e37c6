// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/slam_rows.h"

#include "storage/postgres/driver/pose_columns.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kUpsertSubmap{
    "storing a submap",
    "INSERT INTO enfilade.slam_submaps AS s (site_id, session_id, submap_id, version, x, y, yaw, finished, content)"
    " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)"
    " ON CONFLICT (site_id, session_id, submap_id) DO UPDATE SET version = EXCLUDED.version, x = EXCLUDED.x,"
    " y = EXCLUDED.y, yaw = EXCLUDED.yaw, finished = EXCLUDED.finished,"
    " content = CASE WHEN octet_length(EXCLUDED.content) = 0 THEN s.content ELSE EXCLUDED.content END"};
// After the graph is solved, thousands of nodes may be stored again: one statement takes arrays (nine numbers for each
// covariance) and does not write rows that have not changed.
constexpr Statement kUpsertNodes{
    "storing nodes",
    "INSERT INTO enfilade.slam_nodes AS n (site_id, session_id, node_id, sequence, time_ns, x, y, yaw, submap_id,"
    "   covariance)"
    " SELECT $1, $2, u.node_id, u.sequence, u.time_ns, u.x, u.y, u.yaw, u.submap_id, ($10::float8[])[9*i-8:9*i]"
    " FROM unnest($3::bigint[], $4::bigint[], $5::bigint[], $6::float8[], $7::float8[], $8::float8[], $9::bigint[])"
    "   WITH ORDINALITY AS u (node_id, sequence, time_ns, x, y, yaw, submap_id, i)"
    " ON CONFLICT (site_id, session_id, node_id) DO UPDATE SET sequence = EXCLUDED.sequence,"
    " time_ns = EXCLUDED.time_ns, x = EXCLUDED.x, y = EXCLUDED.y, yaw = EXCLUDED.yaw, submap_id = EXCLUDED.submap_id,"
    " covariance = EXCLUDED.covariance"
    " WHERE (n.sequence, n.time_ns, n.x, n.y, n.yaw, n.submap_id, n.covariance) IS DISTINCT FROM (EXCLUDED.sequence,"
    " EXCLUDED.time_ns, EXCLUDED.x, EXCLUDED.y, EXCLUDED.yaw, EXCLUDED.submap_id, EXCLUDED.covariance)"};
constexpr Statement kUpsertLoopClosure{
    "storing a closure",
    "INSERT INTO enfilade.slam_closures (site_id, session_id, closure_id, submap_id, node_id, x, y, yaw, information,"
    "   state, score, chi2, reason)"
    " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)"
    " ON CONFLICT (site_id, session_id, closure_id) DO UPDATE SET submap_id = EXCLUDED.submap_id,"
    " node_id = EXCLUDED.node_id, x = EXCLUDED.x, y = EXCLUDED.y, yaw = EXCLUDED.yaw,"
    " information = EXCLUDED.information, state = EXCLUDED.state, score = EXCLUDED.score, chi2 = EXCLUDED.chi2,"
    " reason = EXCLUDED.reason"};
constexpr Statement kUpsertTrajectory{
    "storing the trajectory",
    "INSERT INTO enfilade.trajectory_points (site_id, session_id, sequence, time_ns, node_id, x, y, yaw)"
    " SELECT $1, $2, u.* FROM unnest($3::bigint[], $4::bigint[], $5::bigint[], $6::float8[], $7::float8[],"
    "   $8::float8[]) u"
    " ON CONFLICT (site_id, session_id, sequence) DO UPDATE SET time_ns = EXCLUDED.time_ns,"
    " node_id = EXCLUDED.node_id, x = EXCLUDED.x, y = EXCLUDED.y, yaw = EXCLUDED.yaw"};

constexpr Statement kSelectSubmaps{"reading submaps",
                                   "SELECT submap_id, version, x, y, yaw, finished, content FROM enfilade.slam_submaps"
                                   " WHERE site_id = $1 AND session_id = $2 ORDER BY submap_id"};
constexpr Statement kSelectNodes{
    "reading nodes",
    "SELECT node_id, sequence, time_ns, x, y, yaw, covariance, submap_id FROM enfilade.slam_nodes"
    " WHERE site_id = $1 AND session_id = $2 ORDER BY node_id"};
constexpr Statement kSelectLoopClosures{
    "reading closures", "SELECT " ENFILADE_LOOP_CLOSURE_COLUMNS
                        " FROM enfilade.slam_closures WHERE site_id = $1 AND session_id = $2 ORDER BY closure_id"};
constexpr Statement kSelectTrajectory{"reading the trajectory",
                                      "SELECT sequence, time_ns, node_id, x, y, yaw FROM enfilade.trajectory_points"
                                      " WHERE site_id = $1 AND session_id = $2 ORDER BY sequence"};

void AppendMatrix(const Eigen::Matrix3d& matrix, std::vector<double>& numbers) {
  for (int i = 0; i < 9; ++i) numbers.push_back(matrix(i / 3, i % 3));
}

Eigen::Matrix3d ReadMatrix(Row& row) {
  const std::vector<double> numbers = row.Doubles();
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < std::min<std::size_t>(numbers.size(), 9); ++i) {
    matrix(static_cast<int>(i) / 3, static_cast<int>(i) % 3) = numbers[i];
  }
  return matrix;
}

slam::SlamSubmap ReadSubmap(Row& row) {
  slam::SlamSubmap submap;
  submap.id = row.Int64();
  submap.version = row.Int64();
  submap.T_map_submap = ReadPose(row);
  submap.finished = row.Bool();
  submap.content = row.Bytes();
  return submap;
}

slam::SlamNode ReadNode(Row& row) {
  slam::SlamNode node;
  node.id = row.Int64();
  node.sequence = row.Int64();
  node.time = row.Int64();
  node.T_map_node = ReadPose(row);
  node.covariance = ReadMatrix(row);
  node.submap = row.Int64();
  return node;
}

slam::TrajectoryPoint ReadTrajectoryPoint(Row& row) {
  slam::TrajectoryPoint point;
  point.sequence = row.Int64();
  point.time = row.Int64();
  point.node = row.Int64();
  point.T_node_robot = ReadPose(row);
  return point;
}

void QueueNodes(Transaction& transaction, const SiteId& site, const SessionId& session,
                const std::vector<slam::SlamNode>& nodes) {
  std::vector<std::int64_t> ids, sequences, times, submaps;
  std::vector<double> x, y, yaw, covariances;
  for (const slam::SlamNode& node : nodes) {
    ids.push_back(node.id);
    sequences.push_back(node.sequence);
    times.push_back(node.time);
    submaps.push_back(node.submap);
    x.push_back(node.T_map_node.x);
    y.push_back(node.T_map_node.y);
    yaw.push_back(node.T_map_node.yaw);
    AppendMatrix(node.covariance, covariances);
  }
  transaction.Queue(kUpsertNodes, Params(site, session, ids, sequences, times, x, y, yaw, submaps, covariances));
}

void QueueTrajectory(Transaction& transaction, const SiteId& site, const SessionId& session,
                     const std::vector<slam::TrajectoryPoint>& points) {
  std::vector<std::int64_t> sequences, times, nodes;
  std::vector<double> x, y, yaw;
  for (const slam::TrajectoryPoint& point : points) {
    sequences.push_back(point.sequence);
    times.push_back(point.time);
    nodes.push_back(point.node);
    x.push_back(point.T_node_robot.x);
    y.push_back(point.T_node_robot.y);
    yaw.push_back(point.T_node_robot.yaw);
  }
  transaction.Queue(kUpsertTrajectory, Params(site, session, sequences, times, nodes, x, y, yaw));
}

}  // namespace

slam::LoopClosure ReadLoopClosure(Row& row) {
  slam::LoopClosure closure;
  closure.id = row.Int64();
  closure.submap = row.Int64();
  closure.node = row.Int64();
  closure.T_submap_node = ReadPose(row);
  closure.information = ReadMatrix(row);
  closure.state = static_cast<slam::LoopClosureState>(row.Int16());
  closure.score = row.Double();
  closure.chi2 = row.Double();
  closure.reason = row.Text();
  return closure;
}

// Referenced rows first.
void QueueDelta(Transaction& transaction, const SiteId& site, const SessionId& session, const slam::SlamDelta& delta) {
  for (const slam::SlamSubmap& submap : delta.submaps) {
    const Pose2& pose = submap.T_map_submap;
    transaction.Queue(kUpsertSubmap, Params(site, session, submap.id, submap.version, pose.x, pose.y, pose.yaw,
                                            submap.finished, Bytes{submap.content}));
  }
  if (!delta.nodes.empty()) QueueNodes(transaction, site, session, delta.nodes);
  for (const slam::LoopClosure& closure : delta.loop_closures) {
    const Pose2& pose = closure.T_submap_node;
    std::vector<double> information;
    AppendMatrix(closure.information, information);
    transaction.Queue(
        kUpsertLoopClosure,
        Params(site, session, closure.id, closure.submap, closure.node, pose.x, pose.y, pose.yaw, information,
               static_cast<std::int16_t>(closure.state), closure.score, closure.chi2, closure.reason));
  }
  if (!delta.trajectory.empty()) QueueTrajectory(transaction, site, session, delta.trajectory);
}

absl::StatusOr<std::vector<slam::SlamNode>> ListNodes(Pool& pool, const CallContext& context, const SiteId& site,
                                                      const SessionId& session) {
  ENFILADE_ASSIGN_OR_RETURN(const auto listed, ExecuteAlone(pool, context, kSelectNodes, Params(site, session)));
  return ReadRows(listed, ReadNode);
}

void QueueSlamMap(Transaction& transaction, const SiteId& site, const SessionId& session) {
  for (const Statement* statement : {&kSelectSubmaps, &kSelectNodes, &kSelectLoopClosures, &kSelectTrajectory}) {
    transaction.Queue(*statement, Params(site, session));
  }
}

absl::StatusOr<slam::SlamMap> ReadSlamMap(const Result& submaps, const Result& nodes, const Result& closures,
                                          const Result& trajectory) {
  slam::SlamDelta all;
  ENFILADE_ASSIGN_OR_RETURN(all.submaps, ReadRows(submaps, ReadSubmap));
  ENFILADE_ASSIGN_OR_RETURN(all.nodes, ReadRows(nodes, ReadNode));
  ENFILADE_ASSIGN_OR_RETURN(all.loop_closures, ReadRows(closures, ReadLoopClosure));
  ENFILADE_ASSIGN_OR_RETURN(all.trajectory, ReadRows(trajectory, ReadTrajectoryPoint));
  slam::SlamMap map;
  map.Apply(std::move(all));
  return map;
}

}  // namespace enfilade::storage::postgres

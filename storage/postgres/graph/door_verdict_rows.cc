// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/door_verdict_rows.h"

#include <optional>
#include <string>

#include "storage/postgres/driver/pose_columns.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kInsertVerdict{
    "storing the verdict",
    "INSERT INTO enfilade.door_verdicts (site_id, session_id, sequence, decision, link_point_id, map_id, x, y, yaw,"
    " covariance, odom_x, odom_y, odom_yaw, evidence, reason, graph_version)"
    " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16)"};
constexpr Statement kInsertComparison{
    "storing a comparison",
    "INSERT INTO enfilade.door_comparisons (site_id, session_id, sequence, ordinal, link_point_id, map_id, distance,"
    " image_matches, images_agree, rmse, inlier_share, clouds_agree, chi2, accepted, reason)"
    " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15)"};

}  // namespace

closure::DoorVerdict ReadVerdict(Row& row) {
  closure::DoorVerdict verdict;
  verdict.session = SessionId(std::string(row.Text()));
  verdict.sequence = row.Int64();
  verdict.decision = static_cast<closure::DoorDecision>(row.Int16());
  if (const auto link_point = row.OptionalText()) verdict.link_point = LinkPointId(std::string(*link_point));
  if (const auto map = row.OptionalText()) verdict.entered_map = MapId(std::string(*map));
  verdict.T_map_robot = ReadOptionalPoseWithCovariance(row);
  verdict.T_odom_robot = ReadOptionalPose(row);
  for (const double sequence : row.Doubles()) verdict.evidence.push_back(static_cast<std::int64_t>(sequence));
  verdict.reason = row.Text();
  verdict.graph_version = row.Int64();
  verdict.create_time = row.Time();
  return verdict;
}

ComparisonRow ReadComparison(Row& row) {
  ComparisonRow out;
  out.sequence = row.Int64();
  closure::DoorComparison& comparison = out.comparison;
  comparison.link_point = LinkPointId(std::string(row.Text()));
  comparison.map = MapId(std::string(row.Text()));
  comparison.distance = row.OptionalDouble();
  if (const auto matches = row.OptionalInt64()) comparison.image_matches = static_cast<int>(*matches);
  comparison.images_agree = row.Bool();
  comparison.rmse = row.OptionalDouble();
  comparison.inlier_share = row.Double();
  comparison.clouds_agree = row.Bool();
  comparison.chi2 = row.OptionalDouble();
  comparison.accepted = row.Bool();
  comparison.reason = row.Text();
  return out;
}

void QueueVerdict(Transaction& transaction, const SiteId& site, const closure::DoorVerdict& verdict) {
  const PoseColumns pose(verdict.T_map_robot), odom(verdict.T_odom_robot);
  transaction.Queue(kInsertVerdict,
                    Params(site, verdict.session, verdict.sequence, static_cast<std::int16_t>(verdict.decision),
                           verdict.link_point, verdict.entered_map, pose.x, pose.y, pose.yaw, pose.covariance, odom.x,
                           odom.y, odom.yaw, verdict.evidence, verdict.reason, verdict.graph_version));
  std::int32_t ordinal = 0;
  for (const closure::DoorComparison& comparison : verdict.comparisons) {
    std::optional<std::int32_t> matches;
    if (comparison.image_matches) matches = *comparison.image_matches;
    transaction.Queue(
        kInsertComparison,
        Params(site, verdict.session, verdict.sequence, ++ordinal, comparison.link_point, comparison.map,
               comparison.distance, matches, comparison.images_agree, comparison.rmse, comparison.inlier_share,
               comparison.clouds_agree, comparison.chi2, comparison.accepted, comparison.reason));
  }
}

}  // namespace enfilade::storage::postgres

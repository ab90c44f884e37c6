// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/session_scene.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "server/app/closure/judging_lease.h"

namespace enfilade::server {
namespace {

// A candidate is reported some time after it was seen, but not after more records than this.
constexpr std::int64_t kRecordsBefore = 20'000;
constexpr std::int64_t kRecordsAfter = 500;  // records may arrive a little late
constexpr TimeNs kMargin = 10 * kNsPerSecond;

}  // namespace

absl::StatusOr<SessionScene> SessionScene::Load(const DoorClosureStores& stores, const storage::Session& session,
                                                const storage::StoredDoorReport& stored,
                                                const closure::DoorClosureOptions& options) {
  const sensor::DoorReport& report = stored.report;
  ENFILADE_ASSIGN_OR_RETURN(storage::Trajectory trajectory,
                            stores.mappings.ReadTrajectory(JudgingLease::Context(), session.site, session.id));
  ENFILADE_ASSIGN_OR_RETURN(
      std::vector<sensor::Record> records,
      stores.records.ReadSelected(JudgingLease::Context(), session.site, session.id,
                                  {.kinds = {sensor::RecordKind::kLaserScan, sensor::RecordKind::kOdometry,
                                             sensor::RecordKind::kImage, sensor::RecordKind::kPointCloud},
                                   .from_time = report.door_time - kMargin,
                                   .to_time = report.time + kMargin,
                                   .first_sequence = stored.sequence - kRecordsBefore,
                                   .last_sequence = stored.sequence + kRecordsAfter}));
  ENFILADE_ASSIGN_OR_RETURN(const auto keyframe, stores.mappings.FindKeyframe(JudgingLease::Context(), session.site,
                                                                              session.id, report.time));
  const Eigen::Matrix3d covariance = keyframe ? keyframe->covariance : Eigen::Matrix3d::Zero().eval();
  SessionScene scene(std::move(trajectory.poses), std::move(records), covariance, report, options);
  scene.start_.time = session.first_time.value_or(report.door_time);
  if (session.entry.T_map_robot) scene.start_.T_map_robot = session.entry.T_map_robot->pose;
  return scene;
}

SessionScene::SessionScene(std::vector<slam::StampedPose> trajectory, std::vector<sensor::Record> records,
                           const Eigen::Matrix3d& keyframe_covariance, const sensor::DoorReport& report,
                           const closure::DoorClosureOptions& options)
    : track_({}, {}, options), report_(report), keyframe_covariance_(keyframe_covariance) {
  std::vector<sensor::Odometry> odometry;
  for (sensor::Record& record : records) {
    if (auto* sample = std::get_if<sensor::Odometry>(&record.payload)) {
      odometry.push_back(*sample);
    } else if (auto* image = std::get_if<sensor::Image>(&record.payload)) {
      images_.push_back({record.sequence, std::move(*image)});
    } else if (auto* cloud = std::get_if<sensor::PointCloud>(&record.payload)) {
      clouds_.push_back({record.sequence, std::move(*cloud)});
    } else if (auto* scan = std::get_if<sensor::LaserScan>(&record.payload); scan && scan->time >= report.door_time) {
      scans_.push_back(std::move(*scan));
    }
  }
  track_ = closure::SessionTrack(std::move(trajectory), std::move(odometry), options);
}

std::optional<PoseWithCovariance> SessionScene::PoseAt(TimeNs time) const {
  std::optional<PoseWithCovariance> pose = track_.PoseAt(time);
  if (pose) pose->covariance += keyframe_covariance_;
  return pose;
}

std::optional<PoseWithCovariance> SessionScene::DoorPose() const {
  std::optional<PoseWithCovariance> pose = track_.ToMap(report_.T_odom_door, report_.door_time);
  if (pose) pose->covariance += keyframe_covariance_;
  return pose;
}

closure::DoorByOdometry SessionScene::GuessByOdometry() const {
  closure::DoorByOdometry guess;
  guess.T_map_robot = track_.GuessPoseAt(report_.time, start_);
  guess.T_map_robot.covariance += keyframe_covariance_;
  // The same odometry saw the door and the robot, so that their relative pose is better than either.
  const std::optional<Pose2> T_odom_robot = track_.OdometryAt(report_.time);
  if (T_odom_robot) {
    guess.T_door_robot.pose = Between(report_.T_odom_door, *T_odom_robot);
    const double way = guess.T_door_robot.pose.translation().norm();
    guess.T_door_robot.covariance.diagonal() << 0.01 + 0.01 * way, 0.01 + 0.01 * way, 0.01;
  } else {
    guess.T_door_robot.covariance.diagonal() << 1.0, 1.0, 0.1;
  }
  guess.T_map_door = Compose(guess.T_map_robot, Inverse(guess.T_door_robot));
  return guess;
}

std::vector<SessionScene::SeenImage> SessionScene::FindImages(sensor::Camera camera, const ViewWindow& window,
                                                              int count) const {
  std::vector<SeenImage> found;
  for (const SeenImage& seen : images_) {
    const bool is_picture = seen.image.encoding != sensor::ImageEncoding::kDepthPng16;
    if (is_picture && seen.image.camera == camera && seen.image.time >= window.from && seen.image.time <= window.to) {
      found.push_back(seen);
    }
  }
  std::stable_sort(found.begin(), found.end(), [&](const SeenImage& a, const SeenImage& b) {
    return std::abs(a.image.time - window.time) < std::abs(b.image.time - window.time);
  });
  if (found.size() > static_cast<std::size_t>(count)) found.resize(static_cast<std::size_t>(count));
  return found;
}

std::optional<SessionScene::SeenCloud> SessionScene::FindCloud(const ViewWindow& window) const {
  const SeenCloud* nearest = nullptr;
  for (const SeenCloud& seen : clouds_) {
    if (seen.cloud.time < window.from || seen.cloud.time > window.to) continue;
    if (nearest == nullptr || std::abs(seen.cloud.time - window.time) < std::abs(nearest->cloud.time - window.time))
      nearest = &seen;
  }
  if (nearest == nullptr) return std::nullopt;
  return *nearest;
}

bool SessionScene::HasViews(const ViewWindow& window) const {
  return !FindImages(sensor::Camera::kFront, window, 1).empty() ||
         !FindImages(sensor::Camera::kRear, window, 1).empty() || FindCloud(window).has_value();
}

std::vector<closure::PlacedScan> SessionScene::ScansBetween(TimeNs from, TimeNs to) const {
  constexpr double kLater = 0.5;     // share of the path
  constexpr double kSpacing = 0.25;  // m
  const auto first = PoseAt(from);
  const auto last = PoseAt(to);
  std::vector<closure::PlacedScan> placed;
  if (!first || !last) return placed;
  const double way = (last->pose.translation() - first->pose.translation()).norm();
  for (auto scan = scans_.rbegin(); scan != scans_.rend(); ++scan) {
    const auto pose = scan->time >= from && scan->time <= to ? PoseAt(scan->time) : std::nullopt;
    if (!pose || (last->pose.translation() - pose->pose.translation()).norm() > kLater * way) continue;
    const bool is_new =
        placed.empty() || (placed.back().T_map_robot.pose.translation() - pose->pose.translation()).norm() >= kSpacing;
    if (is_new) placed.push_back({*scan, *pose});
  }
  return placed;
}

}  // namespace enfilade::server

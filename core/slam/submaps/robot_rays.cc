// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/robot_rays.h"

#include <cmath>

namespace enfilade::slam {
namespace {

// Not inlined: GCC 12 vectorises the loops below two points at a time and forgets the last of an odd number.
[[gnu::noinline]] double ToSinglePrecision(double value) { return static_cast<double>(static_cast<float>(value)); }

Eigen::Vector2d Rounded(const Eigen::Vector2d& p) { return {ToSinglePrecision(p.x()), ToSinglePrecision(p.y())}; }

void PutPoints(BinaryWriter& writer, const std::vector<Eigen::Vector2d>& points) {
  writer.Put<std::uint64_t>(points.size());
  for (const auto& p : points) writer.Put(static_cast<float>(p.x()));
  for (const auto& p : points) writer.Put(static_cast<float>(p.y()));
}

std::vector<Eigen::Vector2d> GetPoints(BinaryReader& reader) {
  const auto size = reader.Get<std::uint64_t>();
  if (size > reader.remaining() / (2 * sizeof(float))) return {};
  std::vector<Eigen::Vector2d> points(size);
  for (auto& p : points) p.x() = reader.Get<float>();
  for (auto& p : points) p.y() = reader.Get<float>();
  return points;
}

}  // namespace

grid::ScanRays RobotRays(const sensor::LaserScan& scan, const grid::ScanRayOptions& options) {
  grid::ScanRays rays = grid::RaysOf(scan, Pose2{}, options);
  rays.origin = Rounded(rays.origin);
  for (Eigen::Vector2d& p : rays.hits) p = Rounded(p);
  for (Eigen::Vector2d& p : rays.free_ends) p = Rounded(p);
  return rays;
}

grid::ScanRays Transformed(const Pose2& T_target_source, const grid::ScanRays& rays) {
  Eigen::Matrix2d R;
  R << std::cos(T_target_source.yaw), -std::sin(T_target_source.yaw), std::sin(T_target_source.yaw),
      std::cos(T_target_source.yaw);
  const Eigen::Vector2d t = T_target_source.translation();
  grid::ScanRays result;
  result.origin = R * rays.origin + t;
  result.hits.reserve(rays.hits.size());
  for (const Eigen::Vector2d& p : rays.hits) result.hits.emplace_back(R * p + t);
  result.free_ends.reserve(rays.free_ends.size());
  for (const Eigen::Vector2d& p : rays.free_ends) result.free_ends.emplace_back(R * p + t);
  return result;
}

void PutRays(BinaryWriter& writer, const grid::ScanRays& rays) {
  PutPoints(writer, {rays.origin});
  PutPoints(writer, rays.hits);
  PutPoints(writer, rays.free_ends);
}

grid::ScanRays GetRays(BinaryReader& reader) {
  grid::ScanRays rays;
  if (const auto origin = GetPoints(reader); origin.size() == 1) rays.origin = origin.front();
  rays.hits = GetPoints(reader);
  rays.free_ends = GetPoints(reader);
  return rays;
}

}  // namespace enfilade::slam

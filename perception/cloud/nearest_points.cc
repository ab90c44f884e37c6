// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/nearest_points.h"

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <exception>
#include <utility>

#include "core/base/error.h"

namespace enfilade::perception {
namespace {

pcl::PointXYZ ToPcl(const Eigen::Vector3f& point) { return {point.x(), point.y(), point.z()}; }

}  // namespace

struct NearestPoints::Tree {
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
};

NearestPoints::NearestPoints(std::unique_ptr<Tree> tree) : tree_(std::move(tree)) {}
NearestPoints::~NearestPoints() = default;
NearestPoints::NearestPoints(NearestPoints&&) noexcept = default;
NearestPoints& NearestPoints::operator=(NearestPoints&&) noexcept = default;

absl::StatusOr<NearestPoints> NearestPoints::Make(std::span<const Eigen::Vector3f> points) {
  if (points.empty()) return InvalidArgument("there are no points to search in");
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    if (!point.allFinite()) return InvalidArgument("points that are not finite cannot be searched");
    cloud->push_back(ToPcl(point));
  }
  try {
    auto tree = std::make_unique<Tree>();
    tree->tree.setInputCloud(cloud);
    return NearestPoints(std::move(tree));
  } catch (const std::exception& error) {
    return Internal("building a kd-tree of {} points: PCL failed: {}", points.size(), error.what());
  }
}

NearPoint NearestPoints::Nearest(const Eigen::Vector3f& point) const {
  thread_local std::vector<int> indices(1);
  thread_local std::vector<float> squared(1);
  if (!point.allFinite() || tree_->tree.nearestKSearch(ToPcl(point), 1, indices, squared) == 0) return {};
  return {indices[0], squared[0]};
}

std::vector<int> NearestPoints::Neighbours(const Eigen::Vector3f& point, int count) const {
  std::vector<int> indices;
  std::vector<float> squared;
  if (point.allFinite()) tree_->tree.nearestKSearch(ToPcl(point), count, indices, squared);
  return indices;
}

}  // namespace enfilade::perception

// SPDX-License-Identifier: Apache-2.0
#include "client/robot/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace enfilade::robot {
namespace {

using client::SpoolItem;

// `count` of `size` positions, the first and the last among them, evenly spread.
std::vector<std::size_t> Spread(std::size_t size, std::size_t count) {
  std::vector<std::size_t> positions;
  if (size <= count) {
    for (std::size_t i = 0; i < size; ++i) positions.push_back(i);
  } else if (count == 1) {
    positions.push_back(size - 1);
  } else {
    for (std::size_t i = 0; i < count; ++i) positions.push_back((i * (size - 1) + (count - 1) / 2) / (count - 1));
  }
  return positions;
}

}  // namespace

std::optional<EvidenceBuffer::Kind> EvidenceBuffer::KindOf(const SpoolItem& item) {
  if (std::holds_alternative<sensor::PointCloud>(item.payload)) return Kind::kCloud;
  const auto* image = std::get_if<sensor::Image>(&item.payload);
  if (!image || image->encoding == sensor::ImageEncoding::kDepthPng16) return std::nullopt;
  return image->camera == sensor::Camera::kRear ? Kind::kRear : Kind::kFront;
}

void EvidenceBuffer::Add(const SpoolItem& item, const Pose2& T_odom_robot) {
  const std::optional<Kind> kind = KindOf(item);
  if (!kind) return;
  std::deque<Seen>& seen = seen_[*kind];
  if (!seen.empty() && TimeOf(item) < TimeOf(seen.back().item)) return;  // late: the order is of more use
  // The newest makes way for the next one unless the robot has moved between the one before and it.
  if (seen.size() >= 2) {
    const Pose2 moved = Between(seen[seen.size() - 2].T_odom_robot, seen.back().T_odom_robot);
    const bool turned = std::abs(moved.yaw) * 180.0 / M_PI >= options_.turn;
    if (moved.translation().norm() < options_.spacing && !turned) seen.pop_back();
  }
  seen.push_back({item, T_odom_robot});
  while (seen.size() > static_cast<std::size_t>(options_.kept)) seen.pop_front();
}

std::vector<SpoolItem> EvidenceBuffer::At(TimeNs time) const {
  std::vector<SpoolItem> items;
  for (const auto& [kind, seen] : seen_) {
    const Seen* nearest = nullptr;
    for (const Seen& one : seen) {
      const DurationNs gap = std::llabs(TimeOf(one.item) - time);
      if (ToSeconds(gap) > options_.max_age) continue;
      if (!nearest || gap < std::llabs(TimeOf(nearest->item) - time)) nearest = &one;
    }
    if (nearest) items.push_back(nearest->item);
  }
  return items;
}

std::vector<SpoolItem> EvidenceBuffer::Behind(const sensor::DoorReport& report) const {
  const auto age = static_cast<DurationNs>(options_.max_age * static_cast<double>(kNsPerSecond));
  const TimeNs from = report.by_hand ? report.time - age : report.door_time;
  std::vector<SpoolItem> items;
  for (const auto& [kind, seen] : seen_) {
    std::vector<const Seen*> behind;
    for (const Seen& one : seen) {
      const TimeNs time = TimeOf(one.item);
      if (time > from && time <= report.time) behind.push_back(&one);
    }
    if (kind == Kind::kCloud) {
      const auto farthest = std::max_element(behind.begin(), behind.end(), [&](const Seen* a, const Seen* b) {
        const Eigen::Vector2d door = report.T_odom_door.translation();
        return (a->T_odom_robot.translation() - door).norm() < (b->T_odom_robot.translation() - door).norm();
      });
      if (farthest != behind.end()) items.push_back((*farthest)->item);
      continue;
    }
    for (const std::size_t i : Spread(behind.size(), static_cast<std::size_t>(options_.images))) {
      items.push_back(behind[i]->item);
    }
  }
  return items;
}

std::size_t EvidenceBuffer::size() const {
  std::size_t size = 0;
  for (const auto& [kind, seen] : seen_) size += seen.size();
  return size;
}

std::vector<SpoolItem> Joined(std::vector<SpoolItem> a, const std::vector<SpoolItem>& b) {
  a.insert(a.end(), b.begin(), b.end());
  std::stable_sort(a.begin(), a.end(), [](const SpoolItem& x, const SpoolItem& y) { return TimeOf(x) < TimeOf(y); });
  a.erase(
      std::unique(a.begin(), a.end(), [](const SpoolItem& x, const SpoolItem& y) { return x.payload == y.payload; }),
      a.end());
  return a;
}

}  // namespace enfilade::robot

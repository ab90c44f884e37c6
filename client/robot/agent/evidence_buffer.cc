// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/evidence_buffer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace enfilade::robot {
namespace {

using client::SpoolItem;

// `count` of `size` positions, evenly spread, with the first and the last.
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
  std::deque<Entry>& entries = entries_[*kind];
  if (!entries.empty() && TimeOf(item) < TimeOf(entries.back().item)) return;  // late: keeping the order matters more
  // The newest entry is replaced unless the robot has moved between the one before it and it.
  if (entries.size() >= 2) {
    const Pose2 moved = Between(entries[entries.size() - 2].T_odom_robot, entries.back().T_odom_robot);
    const bool turned = std::abs(moved.yaw) * 180.0 / M_PI >= options_.turn;
    if (moved.translation().norm() < options_.spacing && !turned) entries.pop_back();
  }
  entries.push_back({item, T_odom_robot});
  while (entries.size() > static_cast<std::size_t>(options_.kept)) entries.pop_front();
}

std::vector<SpoolItem> EvidenceBuffer::NearestTo(TimeNs time) const {
  std::vector<SpoolItem> items;
  for (const auto& [kind, entries] : entries_) {
    const Entry* nearest = nullptr;
    for (const Entry& entry : entries) {
      const DurationNs gap = std::llabs(TimeOf(entry.item) - time);
      if (ToSeconds(gap) > options_.max_age) continue;
      if (!nearest || gap < std::llabs(TimeOf(nearest->item) - time)) nearest = &entry;
    }
    if (nearest) items.push_back(nearest->item);
  }
  return items;
}

std::vector<SpoolItem> EvidenceBuffer::BehindDoor(const sensor::DoorReport& report) const {
  const auto age = static_cast<DurationNs>(options_.max_age * static_cast<double>(kNsPerSecond));
  const TimeNs from = report.by_hand ? report.time - age : report.door_time;
  std::vector<SpoolItem> items;
  for (const auto& [kind, entries] : entries_) {
    std::vector<const Entry*> behind;
    for (const Entry& entry : entries) {
      const TimeNs time = TimeOf(entry.item);
      if (time > from && time <= report.time) behind.push_back(&entry);
    }
    if (kind == Kind::kCloud) {
      const auto farthest = std::max_element(behind.begin(), behind.end(), [&](const Entry* a, const Entry* b) {
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
  for (const auto& [kind, entries] : entries_) size += entries.size();
  return size;
}

std::vector<SpoolItem> MergedByTime(std::vector<SpoolItem> a, const std::vector<SpoolItem>& b) {
  for (const SpoolItem& item : b) {
    const bool known = std::any_of(a.begin(), a.end(), [&](const SpoolItem& x) { return x.payload == item.payload; });
    if (!known) a.push_back(item);
  }
  std::stable_sort(a.begin(), a.end(), [](const SpoolItem& x, const SpoolItem& y) { return TimeOf(x) < TimeOf(y); });
  return a;
}

}  // namespace enfilade::robot

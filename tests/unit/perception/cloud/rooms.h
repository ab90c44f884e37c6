// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>
#include <random>
#include <string>

#include "fmt/format.h"
#include "perception/cloud/cloud.h"

namespace enfilade::perception::testing {

inline Eigen::Isometry3d PoseOf(double x, double y, double yaw, double z = 0.0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

// Points on the walls, the floor and a few boxes of a room of its own, in the room's frame; `noise` in m.
inline Cloud Room(std::uint32_t room_seed, std::uint32_t noise_seed, double noise = 0.01, int points = 20000) {
  std::mt19937 shape(room_seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Eigen::Vector3d size(6.0 + 6.0 * unit(shape), 5.0 + 4.0 * unit(shape), 2.5);
  struct Box {
    Eigen::Vector3d low;
    Eigen::Vector3d high;
  };
  std::vector<Box> boxes = {{-0.5 * size, 0.5 * size}};
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d low((unit(shape) - 0.5) * (size.x() - 2.0), (unit(shape) - 0.5) * (size.y() - 2.0), -1.25);
    boxes.push_back({low, low + Eigen::Vector3d(0.3 + unit(shape), 0.3 + unit(shape), 0.5 + 1.5 * unit(shape))});
  }
  std::mt19937 rng(noise_seed);
  std::normal_distribution<double> error(0.0, noise);
  Cloud cloud;
  while (cloud.points.size() < static_cast<std::size_t>(points)) {
    const Box& box = boxes[unit(rng) < 0.6 ? 0 : 1 + rng() % (boxes.size() - 1)];
    Eigen::Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = box.low[k] + unit(rng) * (box.high[k] - box.low[k]);
    const auto axis = static_cast<Eigen::Index>(rng() % 3);
    p[axis] = rng() % 2 == 0 ? box.low[axis] : box.high[axis];
    p += Eigen::Vector3d(error(rng), error(rng), error(rng));
    cloud.points.push_back(p.cast<float>());
  }
  return cloud;
}

// PCD, binary.
inline std::string EncodePcd(const Cloud& cloud) {
  std::string bytes = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
      "WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
      cloud.points.size());
  for (const Eigen::Vector3f& point : cloud.points) {
    bytes.append(reinterpret_cast<const char*>(point.data()), 3 * sizeof(float));
  }
  return bytes;
}

}  // namespace enfilade::perception::testing

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/base/binary.h"
#include "core/geometry/pose2.h"

namespace enfilade {

// x, y, yaw.
inline void PutPose(BinaryWriter& writer, const Pose2& pose) {
  writer.Put(pose.x);
  writer.Put(pose.y);
  writer.Put(pose.yaw);
}

inline Pose2 GetPose(BinaryReader& reader) {
  Pose2 pose;
  pose.x = reader.Get<double>();
  pose.y = reader.Get<double>();
  pose.yaw = reader.Get<double>();
  return pose;
}

// Nine elements in column order.
inline void PutMatrix(BinaryWriter& writer, const Eigen::Matrix3d& matrix) {
  for (int i = 0; i < 9; ++i) writer.Put(matrix.data()[i]);
}

inline Eigen::Matrix3d GetMatrix(BinaryReader& reader) {
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 9; ++i) matrix.data()[i] = reader.Get<double>();
  return matrix;
}

}  // namespace enfilade

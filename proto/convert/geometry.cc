// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/geometry.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/covariance.h"
#include "proto/convert/record.h"

namespace enfilade::convert {

void SetMatrix(const Eigen::Matrix3d& matrix, google::protobuf::RepeatedField<double>* out) {
  out->Resize(9, 0.0);
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(out->mutable_data()) = matrix;
}

v1::PoseWithCovariance ToProto(const PoseWithCovariance& pose) {
  v1::PoseWithCovariance out;
  ToProto(pose, out);
  return out;
}

void ToProto(const PoseWithCovariance& pose, v1::PoseWithCovariance& out) {
  *out.mutable_pose() = ToProto(pose.pose);
  SetMatrix(pose.covariance, out.mutable_covariance());
}

absl::StatusOr<PoseWithCovariance> FromProto(const std::string& field, const v1::PoseWithCovariance& pose) {
  if (!pose.has_pose()) return InvalidArgument("{}.pose is missing", field);
  PoseWithCovariance out{FromProto(pose.pose()), Eigen::Matrix3d::Zero()};
  if (!IsFinite(out.pose)) return InvalidArgument("{}.pose is not finite", field);
  if (pose.covariance_size() == 0) return out;
  if (pose.covariance_size() != 9) {
    return InvalidArgument("{}.covariance has {} numbers: 9 are expected", field, pose.covariance_size());
  }
  out.covariance = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.covariance().data());
  ENFILADE_RETURN_IF_ERROR(WithContext(ValidateCovariance(out.covariance), field));
  return out;
}

}  // namespace enfilade::convert

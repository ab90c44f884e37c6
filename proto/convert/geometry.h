// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/geometry.pb.h"
#include "google/protobuf/repeated_field.h"

namespace enfilade::convert {

v1::PoseWithCovariance ToProto(const PoseWithCovariance& pose);
// Fills a message that is part of another one, without a copy.
void ToProto(const PoseWithCovariance& pose, v1::PoseWithCovariance& out);

// INVALID_ARGUMENT naming `field`: a pose that is missing or not finite, an invalid
// covariance. A missing covariance is zero.
absl::StatusOr<PoseWithCovariance> FromProto(const std::string& field, const v1::PoseWithCovariance& pose);

// Row by row.
void SetMatrix(const Eigen::Matrix3d& matrix, google::protobuf::RepeatedField<double>* out);

}  // namespace enfilade::convert

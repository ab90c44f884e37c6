// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/sensor/record.h"
#include "enfilade/v1/geometry.pb.h"
#include "enfilade/v1/record.pb.h"
#include "google/protobuf/timestamp.pb.h"

namespace enfilade::convert {

// Between the wire's messages and core values, for server and client alike. Exact both ways: no number changes.

v1::Pose2 ToProto(const Pose2& pose);
Pose2 FromProto(const v1::Pose2& pose);

google::protobuf::Timestamp ToTimestamp(TimeNs time);
// INVALID_ARGUMENT outside the years 1970 to 2200 or with nanos out of range.
absl::StatusOr<TimeNs> FromTimestamp(const google::protobuf::Timestamp& time);

void ToProto(const sensor::LaserScan& scan, v1::LaserScan& out);
v1::Record ToProto(const sensor::Record& record);

// INVALID_ARGUMENT naming the field: an unset payload, an unset or unknown enum value, a missing pose or content, and
// all that Validate(Record) refuses.
absl::StatusOr<sensor::Record> FromProto(const v1::Record& record);

}  // namespace enfilade::convert

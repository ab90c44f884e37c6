// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::sources {

// Reads the white-space separated fields of one line one by one, with a name for each. After the first error every
// getter returns zero and `status()` names the field and the error, so that a parser can check once at its end.
class Fields {
 public:
  explicit Fields(std::string_view line) : rest_(line) {}

  std::string_view Word(std::string_view name);
  // A finite number.
  double Number(std::string_view name);
  std::int64_t Integer(std::string_view name);
  // Seconds as exact nanoseconds.
  TimeNs Seconds(std::string_view name);
  // Three finite numbers; lengths are multiplied by `metres_per_unit`.
  Pose2 Pose(std::string_view name, double metres_per_unit = 1.0);
  // `count` numbers times `scale`. NaN and infinities are allowed (sensor::LaserScan defines their meaning).
  std::vector<float> Ranges(std::string_view name, std::int64_t count, double scale = 1.0);
  void Skip(std::string_view name, std::int64_t count);
  // An error unless exactly `count` fields are left; `reason` says why, e.g. "180 ranges are announced".
  void ExpectRemaining(std::int64_t count, const std::string& reason);
  // An error if fields are left.
  void ExpectEnd();

  bool ok() const { return status_.ok(); }
  const absl::Status& status() const { return status_; }

  void Fail(const std::string& message);

 private:
  std::string_view rest_;
  int position_ = 0;  // of the field read last, from 1
  absl::Status status_;
};

// Decimal text in seconds, such as "976052858.304357", as nanoseconds: exact for up to nine decimals, further ones are
// rounded half away from zero. Numbers with exponents ("4.85e-86") are read as a double. False: not a finite number, or
// beyond +-292 years.
bool ParseSeconds(std::string_view text, TimeNs& time);

}  // namespace enfilade::sources

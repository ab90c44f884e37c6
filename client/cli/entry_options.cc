// SPDX-License-Identifier: Apache-2.0
#include "client/cli/entry_options.h"

#include "client/cli/numbers.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {

void AddEntryOptions(CLI::App& command, EntryOptions& options) {
  command.add_option("--at", options.at, "Where the log starts in an existing map: X,Y,YAW in metres and radians");
  command.add_option("--at-sigma", options.sigma, "Standard deviations of that position and heading: M,RAD")
      ->capture_default_str();
}

absl::StatusOr<std::optional<PoseWithCovariance>> EntryOf(const EntryOptions& options) {
  if (options.at.empty()) return std::nullopt;
  const std::optional<std::vector<double>> at = ParseNumbers(options.at, 3);
  if (!at) return InvalidArgument("--at is \"{}\": expected X,Y,YAW in metres and radians", options.at);
  const std::optional<std::vector<double>> sigma = ParseNumbers(options.sigma, 2);
  if (!sigma || !((*sigma)[0] > 0.0) || !((*sigma)[1] > 0.0)) {
    return InvalidArgument("--at-sigma is \"{}\": expected two positive numbers M,RAD", options.sigma);
  }
  PoseWithCovariance entry{{(*at)[0], (*at)[1], WrapAngle((*at)[2])}};
  entry.covariance.diagonal() << (*sigma)[0] * (*sigma)[0], (*sigma)[0] * (*sigma)[0], (*sigma)[1] * (*sigma)[1];
  return entry;
}

}  // namespace enfilade::cli

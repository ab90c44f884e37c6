// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "core/sensor/scan_pairing.h"
#include "enfilade/v1/localization_service.pb.h"
#include "enfilade/v1/prior_map_service.pb.h"

namespace enfilade::client {

// At most this many scans are sent.
constexpr std::size_t kMaxLocalizationScans = 100;
// At most this many scans are sent to locate a robot in a plan.
constexpr std::size_t kMaxPlanScans = 500;

// Asks where in the site's maps the robot is, by its last scans in order of time: one, or several with odometry, of
// which those at least 0.25 m or 0.25 rad apart are sent, the last kMaxLocalizationScans of them. `prior`, if set,
// bounds the search. Errors: LocalizationService.LocalizeRobot's; INVALID_ARGUMENT: no scans.
absl::StatusOr<v1::LocalizeRobotResponse> LocalizeRobot(const Connection& connection, const SiteId& site,
                                                        const std::vector<sensor::PairedScan>& scans,
                                                        const v1::LocalizationPrior& prior = {});

// The request of LocalizeRobot, to be completed: with an image, for example.
v1::LocalizeRobotRequest MakeLocalizeRequest(const SiteId& site, const std::vector<sensor::PairedScan>& scans);

// The request of PriorMapService.LocateInPriorMap, to be completed: with pairs, for example. `name`:
// sites/{site}/priorMaps/{prior_map}. Scans are chosen as for LocalizeRobot, the last kMaxPlanScans of them.
v1::LocateInPriorMapRequest MakeLocateInPriorMapRequest(const std::string& name,
                                                        const std::vector<sensor::PairedScan>& scans);

}  // namespace enfilade::client

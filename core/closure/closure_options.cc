// SPDX-License-Identifier: Apache-2.0
#include "core/closure/closure_options.h"

#include <type_traits>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::closure {

absl::Status DoorClosureOptions::Validate() const {
  absl::Status status;
  VisitDoorClosureOptions(*this, [&](const char* name, const auto& value) {
    if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::string>) {
      const auto number = static_cast<double>(value);
      if (status.ok() && !(number >= 0.0 && number < 1e6)) {
        status = InvalidArgument("{} is {}: expected 0 or more", name, number);
      }
    }
  });
  ENFILADE_RETURN_IF_ERROR(status);
  for (const double probability : {gate_probability, strict_probability}) {
    if (!(probability > 0.0 && probability < 1.0)) {
      return InvalidArgument("gate_probability and strict_probability must be over 0 and less than 1, not {}",
                             probability);
    }
  }
  for (const double sigma : {place_sigma, place_yaw_sigma, pose_sigma, pose_yaw_sigma, origin_sigma, origin_yaw_sigma,
                             ride_yaw_sigma, cloud_voxel}) {
    if (!(sigma > 0.0)) return InvalidArgument("sigmas and cloud_voxel must be greater than 0");
  }
  for (const double ratio : {image_sift_ratio, image_akaze_ratio}) {
    if (!(ratio > 0.0 && ratio <= 1.0)) {
      return InvalidArgument("image_sift_ratio and image_akaze_ratio must be over 0 and at most 1, not {}", ratio);
    }
  }
  if (!(image_tolerance > 0.0 && image_tolerance <= 0.1)) {
    return InvalidArgument("image_tolerance must be over 0 and at most 0.1, not {}", image_tolerance);
  }
  if (locate_scans < 1 || locate_scans > 1000) return InvalidArgument("locate_scans must be 1 to 1000");
  for (const double share : {image_min_share, min_inlier_share, strict_inlier_share, unpredicted_inlier_share,
                             contradicting_share, locate_min_share}) {
    if (share > 1.0) return InvalidArgument("a share must be at most 1, not {}", share);
  }
  if (images_now < 1 || images_kept < 1 || images_compared < 1 || images_kept > 100 || images_now > 100) {
    return InvalidArgument("images_now, images_kept and images_compared must be 1 to 100");
  }
  if (map_name.empty() || map_name.size() > 100) return InvalidArgument("map_name must have 1 to 100 characters");
  return absl::OkStatus();
}

}  // namespace enfilade::closure

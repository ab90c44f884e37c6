// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace enfilade::closure {

// What decides at a door (docs/closure.md). The original's values where it had any: map_manager's params.yaml.
struct DoorClosureOptions {
  // --- The gate: does a pose agree with where it should be? Chi-squared with 3 degrees of freedom, of the sum of both
  // covariances and of what no covariance knows of:
  double gate_probability = 0.99;    // what agrees is let through so often
  double strict_probability = 0.95;  // the same where fewer witnesses are there
  double place_sigma = 0.2;      // m, of a door's pose: found on a raster, from one pass; alone it lets 0.67 m through
  double place_yaw_sigma = 0.2;  // rad: doors are passed obliquely
  double pose_sigma = 0.15;      // m, of a registered pose against the graph's: maps bend a little
  double pose_yaw_sigma = 0.05;  // rad

  // --- Is a door that is seen ahead known already? Both were seen by robots before the door, not in it.
  double known_along = 1.5;    // m along the way, to another sighting
  double known_ahead = 3.5;    // m along the way, to a place that is the door itself
  double known_across = 1.0;   // m across
  double known_facing = 45.0;  // deg

  // --- Which places are compared.
  double search_base = 20.0;   // m: R = base + factor * sqrt(5.991 lambda_max), as the original had it
  double search_factor = 2.0;  // of the 95 % ellipse's larger semi-axis
  int max_compared = 40;       // places by their images, the nearest first
  int max_registered = 4;      // places by their clouds, those with the best images first

  // --- Images.
  int images_now = 6;              // moments of each camera that are compared (the original's num_last_imgs gave 6)
  int images_kept = 6;             // per camera and map, as evidence
  int images_compared = 2;         // of those kept, the nearest to the door's moment
  double image_window = 3.0;       // s around the moment in which images are looked for
  int image_threshold = 15;        // more inliers than this, verified (the original's 30 were not)
  double image_min_share = 0.04;   // of the features in the part that both images show
  double image_sift_ratio = 0.6;   // Lowe's ratio test (the original's NNDR_sift)
  double image_akaze_ratio = 0.7;  // (NNDR_akaze)
  double image_tolerance = 0.006;  // of the longer side: how near a verified match lies to where its plane has it
  int min_features = 40;           // an image with fewer shows nothing: as if it were not there

  // --- Clouds.
  double cloud_window = 3.0;          // s around the moment in which a cloud is looked for
  double cloud_voxel = 0.2;           // m
  double min_inlier_share = 0.5;      // below it two clouds are not of one place; a door hides much of what lies behind
  double strict_inlier_share = 0.75;  // where images cannot tell
  // Where no link points lead, images and clouds alone must tell; the images by so many times image_threshold.
  double unpredicted_inlier_share = 0.6;
  double unpredicted_matches = 2.0;
  double max_fitness = 0.5;          // m^2 (icp_fitness_score_thr)
  double contradicting_share = 0.4;  // below it the cloud speaks against a place that the pose speaks for
  double latch_distance = 1.7;       // m that a robot is before a door when it sees it: where registration begins

  // --- When is the graph alone sure of where the robot is?
  double sure_radius = 1.0;  // m, larger semi-axis of the 95 % ellipse
  double sure_yaw = 0.15;    // rad, standard deviation

  // --- Scans: is the robot in a map that is known, where neither images nor clouds tell of it?
  // m: rooms that look alike are at least so far apart (narrow rooms in a row). A place that is found is the right one
  // where it is nearer to the prediction than any look-alike of it can be, the prediction's error (95 %) allowed for.
  double alike_distance = 2.5;
  double locate_min_share = 0.5;  // of what is seen behind the door, on walls of the map: not all of it is known yet
  double locate_reach = 30.0;     // m about the prediction, of scans that are compared: as far as SLAM lets them see
  int locate_scans = 40;          // of them at most
  double locate_tail = 4.0;       // m: the end of a session that goes on may lie behind a door not yet reported
  // A map that others are in the middle of mapping may turn out to be the one: how long a verdict waits for them.
  double patience_live = 20.0;  // s, while they go on recording
  double patience = 120.0;      // s, for what is recorded and only has to be mapped

  // --- Look-alikes: of two places that would do, one is taken only where it is better by
  double clear_chi2 = 9.0;   // in chi-squared, or
  double clear_score = 1.8;  // times the other's image matches
  double same_pose = 1.0;    // m: two places that say the robot is here within this are no rivals

  // --- A scan's pose against the map that it was matched to: SLAM's floors.
  double match_sigma = 0.02;       // m
  double match_yaw_sigma = 0.005;  // rad

  // --- Odometry's share of a pose's covariance, from the nearest keyframe on.
  double odometry_sigma = 0.02;      // m per m
  double odometry_yaw_sigma = 0.02;  // rad per m

  // --- A new map.
  double origin_sigma = 0.01;       // m: its frame begins at the door, so the door is there by definition
  double origin_yaw_sigma = 0.005;  // rad
  std::string map_name = "Map";     // it is called "Map 3", the least number that is free
  std::string indoor_profile;       // the SLAM profile of a new map indoors; empty: the server's own
  std::string outdoor_profile;

  // INVALID_ARGUMENT naming the option.
  absl::Status Validate() const;
};

// Calls visit(name, value) for every option; `Options` is DoorClosureOptions, const or not.
template <typename Options, typename Visit>
void VisitDoorClosureOptions(Options& o, Visit visit) {
  visit("gate_probability", o.gate_probability);
  visit("strict_probability", o.strict_probability);
  visit("place_sigma", o.place_sigma);
  visit("place_yaw_sigma", o.place_yaw_sigma);
  visit("pose_sigma", o.pose_sigma);
  visit("pose_yaw_sigma", o.pose_yaw_sigma);
  visit("known_along", o.known_along);
  visit("known_ahead", o.known_ahead);
  visit("known_across", o.known_across);
  visit("known_facing", o.known_facing);
  visit("search_base", o.search_base);
  visit("search_factor", o.search_factor);
  visit("max_compared", o.max_compared);
  visit("max_registered", o.max_registered);
  visit("images_now", o.images_now);
  visit("images_kept", o.images_kept);
  visit("images_compared", o.images_compared);
  visit("image_window", o.image_window);
  visit("image_threshold", o.image_threshold);
  visit("image_min_share", o.image_min_share);
  visit("image_sift_ratio", o.image_sift_ratio);
  visit("image_akaze_ratio", o.image_akaze_ratio);
  visit("image_tolerance", o.image_tolerance);
  visit("min_features", o.min_features);
  visit("cloud_window", o.cloud_window);
  visit("cloud_voxel", o.cloud_voxel);
  visit("min_inlier_share", o.min_inlier_share);
  visit("strict_inlier_share", o.strict_inlier_share);
  visit("unpredicted_inlier_share", o.unpredicted_inlier_share);
  visit("unpredicted_matches", o.unpredicted_matches);
  visit("max_fitness", o.max_fitness);
  visit("contradicting_share", o.contradicting_share);
  visit("latch_distance", o.latch_distance);
  visit("sure_radius", o.sure_radius);
  visit("sure_yaw", o.sure_yaw);
  visit("alike_distance", o.alike_distance);
  visit("locate_min_share", o.locate_min_share);
  visit("locate_reach", o.locate_reach);
  visit("locate_scans", o.locate_scans);
  visit("locate_tail", o.locate_tail);
  visit("patience_live", o.patience_live);
  visit("patience", o.patience);
  visit("clear_chi2", o.clear_chi2);
  visit("clear_score", o.clear_score);
  visit("same_pose", o.same_pose);
  visit("match_sigma", o.match_sigma);
  visit("match_yaw_sigma", o.match_yaw_sigma);
  visit("odometry_sigma", o.odometry_sigma);
  visit("odometry_yaw_sigma", o.odometry_yaw_sigma);
  visit("origin_sigma", o.origin_sigma);
  visit("origin_yaw_sigma", o.origin_yaw_sigma);
  visit("map_name", o.map_name);
  visit("indoor_profile", o.indoor_profile);
  visit("outdoor_profile", o.outdoor_profile);
}

// Options from YAML by the names above, on top of `base`. INVALID_ARGUMENT naming key and line: a key that does not
// exist, a value of another type, what Validate refuses.
absl::StatusOr<DoorClosureOptions> ParseDoorClosureOptions(std::string_view yaml, const DoorClosureOptions& base);

}  // namespace enfilade::closure

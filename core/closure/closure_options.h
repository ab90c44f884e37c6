// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"

namespace enfilade::closure {

// The thresholds of closures at doors (docs/closure.md). Where map_manager has the same parameter, the value is that of
// its params.yaml, whose name is given.
struct DoorClosureOptions {
  // --- The gate: does a pose agree with its prediction? Chi-squared with 3 degrees of freedom, of the sum of both
  // covariances and of these errors that neither contains:
  double gate_probability = 0.99;    // share of correct poses that pass
  double strict_probability = 0.95;  // the same if there is less evidence
  double place_sigma = 0.2;          // m, of a door's pose, found on a raster in one pass; alone it lets 0.67 m through
  double place_yaw_sigma = 0.2;      // rad: doors are passed obliquely
  double pose_sigma = 0.15;          // m, of a registered pose against the graph's: maps are slightly bent
  double pose_yaw_sigma = 0.05;      // rad

  // --- Is a door that is seen ahead known already? Both times the robot was in front of the door, not in it.
  double known_along = 1.5;    // m along the way, to another sighting
  double known_ahead = 3.5;    // m along the way, to a link point, which is at the door itself
  double known_across = 1.0;   // m across
  double known_facing = 45.0;  // deg

  // --- Which places are compared.
  double search_base = 20.0;   // m: R = base + factor * sqrt(5.991 lambda_max), as in map_manager
  double search_factor = 2.0;  // of the 95 % ellipse's larger semi-axis
  int max_compared = 40;       // places whose images are compared, the nearest first
  int max_searched = 40;       // maps in which the scans are looked for, the nearest first
  int max_registered = 4;      // places whose clouds are registered, those with the best images first

  // --- Images.
  int images_now = 6;              // of each camera, behind the door (num_last_imgs gives 6)
  int images_kept = 6;             // per camera and map, as evidence
  int images_compared = 2;         // of those kept, the nearest in time to the door
  double image_window = 3.0;       // s before and after, in which images are looked for
  int image_threshold = 15;        // more verified inliers than this (map_manager: 30, not verified)
  double image_min_share = 0.04;   // of the features in the part that both images show
  double image_sift_ratio = 0.6;   // Lowe's ratio test (NNDR_sift)
  double image_akaze_ratio = 0.7;  // (NNDR_akaze)
  double image_tolerance = 0.006;  // share of the longer side: the largest reprojection error of a verified match
  int min_features = 40;           // an image with fewer counts as missing

  // --- Clouds.
  double cloud_window = 3.0;      // s before and after, in which a cloud is looked for
  double cloud_voxel = 0.2;       // m
  double min_inlier_share = 0.5;  // below it two clouds show different places; a door hides much of what lies behind
  double strict_inlier_share = 0.75;  // the same without images that agree
  // The same for maps that no link points lead to, where only images and clouds can tell. The images must have this
  // many times image_threshold.
  double unpredicted_inlier_share = 0.6;
  double unpredicted_matches = 2.0;
  double max_fitness = 0.5;          // m^2 (icp_fitness_score_thr)
  double contradicting_share = 0.4;  // below it the clouds contradict a place that the pose speaks for
  double latch_distance = 1.7;       // m from a robot that sees a door to the door: where registration starts

  // --- When is the graph alone sure of where the robot is?
  double sure_radius = 1.0;  // m, larger semi-axis of the 95 % ellipse
  double sure_yaw = 0.15;    // rad, standard deviation

  // --- Scans: which known map is the robot in, if neither images nor clouds show it?
  // m: the least distance between rooms that look alike (narrow rooms in a row). A pose is accepted only if it is
  // nearer to the prediction than any look-alike can be, the prediction's error (95 %) included.
  double alike_distance = 2.5;
  double locate_min_share = 0.5;  // of the hits behind the door that lie on walls of the map, which may be incomplete
  double locate_reach = 30.0;     // m around the prediction, of scans that are compared: SLAM's largest range
  int locate_scans = 40;          // at most
  double locate_tail = 4.0;       // m: the end of a running session may lie behind a door that is not reported yet
  // How long a verdict waits for maps that are being mapped and that may be the one that the robot entered.
  double patience_live = 20.0;  // s, for sessions that are recording
  double patience = 120.0;      // s, for sessions that are recorded and not mapped yet

  // --- Look-alikes: of two places that are both accepted, one is chosen only if it is better by
  double clear_chi2 = 9.0;   // in chi-squared, or
  double clear_score = 1.8;  // times the other's image matches
  double same_pose = 1.0;    // m: two places that put the robot within this distance do not exclude each other

  // --- A scan's pose in the map that it was matched to: SLAM's least standard deviations.
  double match_sigma = 0.02;       // m
  double match_yaw_sigma = 0.005;  // rad

  // --- Odometry's share of a pose's covariance, since the nearest keyframe.
  double odometry_sigma = 0.02;      // m per m
  double odometry_yaw_sigma = 0.02;  // rad per m

  // --- How a ride shows the heading of the level that it leads to.
  double ride_yaw_sigma = 0.012;  // rad

  // --- A new map.
  double origin_sigma = 0.01;       // m: its frame starts at the door, so the door's pose is exact by definition
  double origin_yaw_sigma = 0.005;  // rad
  std::string map_name = "Map";     // its name is this and the least free number: "Map 3"
  std::string indoor_profile;       // the SLAM profile of a new map indoors; empty: the server's own
  std::string outdoor_profile;

  // INVALID_ARGUMENT naming the option that is out of range.
  absl::Status Validate() const;
};

// The first half of the options: places, images and clouds.
template <typename Options, typename Visit>
void VisitPlaceOptions(Options& o, Visit& visit) {
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
  visit("max_searched", o.max_searched);
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
}

// The second half: scans, the choice and new maps.
template <typename Options, typename Visit>
void VisitChoiceOptions(Options& o, Visit& visit) {
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
  visit("ride_yaw_sigma", o.ride_yaw_sigma);
  visit("map_name", o.map_name);
  visit("indoor_profile", o.indoor_profile);
  visit("outdoor_profile", o.outdoor_profile);
}

// Calls visit(name, value) for every option; `Options` is DoorClosureOptions, const or not.
template <typename Options, typename Visit>
void VisitDoorClosureOptions(Options& o, Visit visit) {
  VisitPlaceOptions(o, visit);
  VisitChoiceOptions(o, visit);
}

}  // namespace enfilade::closure

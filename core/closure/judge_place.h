// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/closure/door_verdict.h"
#include "core/geometry/pose2.h"

namespace enfilade::closure {

// The images kept of a place against those of now.
struct ImageComparison {
  int matches = 0;  // median over the moments
  bool agree = false;
  bool other_place = false;  // they do not agree: the same view from another place, as along a corridor
};

// The cloud kept of a place against that of now.
struct CloudComparison {
  double rmse = 0.0;  // m
  double inlier_share = 0.0;
  bool agree = false;              // the registration was accepted
  PoseWithCovariance T_map_robot;  // by registration, in the map behind the place
};

// A place that the robot may have come through, and what speaks for and against it.
struct PlaceEvidence {
  LinkPointId link_point;
  MapId map;                                    // behind it, where the robot would be
  std::optional<double> distance;               // m, between the place and the door by the graph
  std::optional<ImageComparison> images;        // unset: no images of it or of now, or none that show anything
  std::optional<CloudComparison> clouds;        // unset: no cloud of it or of now, or not registered
  std::optional<PoseWithCovariance> predicted;  // T_map_robot by the graph; unset: no link points lead there
  std::string missing;                          // what could not be compared and why, as text; may be empty
};

struct JudgedPlace {
  bool accepted = false;
  PoseWithCovariance T_map_robot;  // if accepted
  std::optional<double> chi2;      // of the registered pose against the predicted one
  double margin = 0.0;             // how much speaks for it; ranks places
  std::string compared;            // the results of the comparisons, as text
  std::string reason;              // why it was accepted or refused, and `compared`
};

// Judges one place without regard to others. Accepted if
// * images and clouds agree, and the registered pose passes the gate against the prediction; without a prediction both
//   must agree more closely (unpredicted_*);
// * there are no images or they do not agree, but the clouds agree closely (strict_*), pass the strict gate, and the
//   graph is sure of where the robot is;
// * there are no clouds, but the images agree and the graph is sure: then the prediction is the pose.
JudgedPlace JudgePlace(const PlaceEvidence& evidence, const DoorClosureOptions& options);

// True if images and clouds were both compared and both speak against the place: then its pose alone is not enough.
bool IsContradicted(const PlaceEvidence& evidence, const DoorClosureOptions& options);

struct PassageChoice {
  std::optional<std::size_t> chosen;  // index into `evidence`
  std::vector<JudgedPlace> judged;    // as `evidence`
  std::vector<std::size_t> order;     // the best first
  bool ambiguous = false;             // several are accepted, and none is clearly better
  std::string reason;
};

// Which of the places the robot came through. None if none is accepted, or if two are accepted that put the robot at
// different poses and neither is clearly better. The order of `evidence` makes no difference to the place chosen.
PassageChoice ChoosePlace(const std::vector<PlaceEvidence>& evidence, const DoorClosureOptions& options);

// For the verdict.
DoorComparison ToComparison(const PlaceEvidence& evidence, const JudgedPlace& judged);

}  // namespace enfilade::closure

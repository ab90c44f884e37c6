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

// What the images of a place and those of now came to.
struct ImageWitness {
  int matches = 0;  // median over the moments
  bool agree = false;
};

// What the clouds came to.
struct CloudWitness {
  double rmse = 0.0;  // m
  double inlier_share = 0.0;
  bool agree = false;              // registration was accepted
  PoseWithCovariance T_map_robot;  // by registration, in the map behind the place
};

// A place that the robot may have come through, and what speaks for it.
struct PlaceEvidence {
  LinkPointId link_point;
  MapId map;                                    // behind it, where the robot would be
  std::optional<double> distance;               // m, between the place and the door by the graph
  std::optional<ImageWitness> images;           // unset: none of it, none of now, or nothing to see in them
  std::optional<CloudWitness> clouds;           // unset: none of it, none of now, or not registered
  std::optional<PoseWithCovariance> predicted;  // T_map_robot by the graph; unset: no link points lead there
  std::string missing;                          // what could not be compared, for the reason; may be empty
};

struct JudgedPlace {
  bool accepted = false;
  PoseWithCovariance T_map_robot;  // where the robot is, where accepted
  std::optional<double> chi2;      // of the registered pose against the predicted one
  double margin = 0.0;             // how much speaks for it, for the order
  std::string witnesses;           // what was compared, in words
  std::string reason;              // the verdict with it
};

// One place by itself. Accepted where
// * images and clouds agree, and the registered pose passes the gate against the prediction; without a prediction both
//   must agree the better (unpredicted_*);
// * images cannot tell or do not agree, but the clouds agree strictly, pass the strict gate, and the graph is sure of
//   where the robot is;
// * clouds cannot tell, but images agree and the graph is sure: then the prediction is the pose.
JudgedPlace JudgePlace(const PlaceEvidence& evidence, const DoorClosureOptions& options);

// True where both witnesses have been heard and both speak against the place: then its pose alone is not believed.
bool Contradicted(const PlaceEvidence& evidence, const DoorClosureOptions& options);

struct PassageChoice {
  std::optional<std::size_t> chosen;  // index into `evidence`
  std::vector<JudgedPlace> judged;    // as `evidence`
  std::vector<std::size_t> order;     // the best first
  bool ambiguous = false;             // several would do, and none is clearly better
  std::string reason;
};

// Which of all places it was. None where none is accepted, or where two are that place the robot differently and
// neither is clearly better.
PassageChoice ChoosePlace(const std::vector<PlaceEvidence>& evidence, const DoorClosureOptions& options);

// For the verdict.
DoorComparison ToComparison(const PlaceEvidence& evidence, const JudgedPlace& judged);

}  // namespace enfilade::closure

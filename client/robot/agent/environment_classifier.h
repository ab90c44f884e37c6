// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/robot/robot_options.h"
#include "client/sdk/spool/spool.h"
#include "core/base/environment.h"
#include "core/sensor/environment_choice.h"
#include "core/sensor/laser_scan.h"
#include "perception/environment/scene_classifier.h"

namespace enfilade::robot {

// Classifies by the configured criterion whether the robot is indoors or outdoors. Not thread-safe.
class EnvironmentClassifier {
 public:
  struct Verdict {
    std::optional<Environment> environment;  // unset: there is no data to decide by
    std::string reason;
  };

  // Loads the scene classifier if the criterion is 3; errors as SceneClassifier::Load.
  static absl::StatusOr<EnvironmentClassifier> Make(const EnvironmentOptions& options);

  // The newest scan.
  void Add(const sensor::LaserScan& scan) { scan_ = scan; }
  // An image. Only those of the front camera are used.
  void Add(const client::SpoolItem& image);

  // By what was seen since `since`. If the configured criterion has no images or cannot read them, the range criterion
  // decides and the reason says so.
  Verdict Classify(TimeNs since);

 private:
  explicit EnvironmentClassifier(const EnvironmentOptions& options) : options_(options) {}
  Verdict ByRange() const;
  absl::StatusOr<Verdict> BySimilarity(TimeNs since) const;
  absl::StatusOr<Verdict> ByScene(TimeNs since);

  EnvironmentOptions options_;
  std::optional<perception::SceneClassifier> classifier_;
  std::optional<sensor::LaserScan> scan_;
  std::deque<client::SpoolItem> depth_;   // at most num_depth_imgs
  std::deque<client::SpoolItem> photos_;  // at most num_depth_imgs
};

}  // namespace enfilade::robot

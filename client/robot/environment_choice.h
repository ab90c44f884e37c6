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

// Says by the configured criterion whether the robot is indoors or outdoors. Not thread-safe.
class EnvironmentChoice {
 public:
  struct Verdict {
    std::optional<Environment> environment;  // unset: there is nothing to tell by
    std::string reason;
  };

  // Loads the classifier of criterion 3: errors as SceneClassifier::Load.
  static absl::StatusOr<EnvironmentChoice> Make(const ChoiceOptions& options);

  // The newest scan; the last images, of which those of the front camera are looked at.
  void Add(const sensor::LaserScan& scan) { scan_ = scan; }
  void Add(const client::SpoolItem& image);

  // By what was seen after `since`. Where the configured criterion has nothing to look at or cannot read it, by range;
  // the reason says so.
  Verdict Choose(TimeNs since);

 private:
  explicit EnvironmentChoice(const ChoiceOptions& options) : options_(options) {}
  Verdict ByRange() const;
  absl::StatusOr<Verdict> BySimilarity(TimeNs since) const;
  absl::StatusOr<Verdict> ByScene(TimeNs since);

  ChoiceOptions options_;
  std::optional<perception::SceneClassifier> classifier_;
  std::optional<sensor::LaserScan> scan_;
  std::deque<client::SpoolItem> depth_;   // at most num_depth_imgs
  std::deque<client::SpoolItem> photos_;  // at most num_depth_imgs
};

}  // namespace enfilade::robot

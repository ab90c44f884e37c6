// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "perception/environment/scene_classes.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

// Files of a scene classifier: a network in ONNX that takes 1x3x224x224 and gives one number per class, such as a
// Places365 ResNet18 exported by its user; labels and mapping as in scene_classes.h. None comes with this program.
struct SceneClassifierFiles {
  std::string model;
  std::string labels;
  std::string mapping;
};

struct SceneVerdict {
  Environment environment = Environment::kIndoor;
  double outdoor_probability = 0.0;  // sum over the outdoor classes
  std::string best_class;
  double best_probability = 0.0;
};

// Says whether a photograph shows indoors or outdoors (criterion 3 of the original). Not thread-safe: one for each
// thread.
class SceneClassifier {
 public:
  // NOT_FOUND naming the file that is missing and what to do. INVALID_ARGUMENT: labels or mapping (ParseSceneClasses),
  // a model that OpenCV cannot read, one that does not take 1x3x224x224 or whose outputs are not as many as the labels.
  static absl::StatusOr<SceneClassifier> Load(const SceneClassifierFiles& files);
  // The same from a model's bytes.
  static absl::StatusOr<SceneClassifier> Make(std::string_view onnx, std::vector<SceneClass> classes);
  ~SceneClassifier();
  SceneClassifier(SceneClassifier&&) noexcept;
  SceneClassifier& operator=(SceneClassifier&&) noexcept;

  // The image is scaled to 256 pixels on its shorter side and its middle 224x224 taken, as RGB in 0 .. 1 less
  // ImageNet's means, divided by its deviations (the preprocessing of Places365's demo); softmax over the outputs.
  // Outdoors where the outdoor classes together have more than half. INVALID_ARGUMENT: a malformed frame.
  absl::StatusOr<SceneVerdict> Classify(const ColorFrame& frame);

 private:
  struct Network;
  SceneClassifier(std::unique_ptr<Network> network, std::vector<SceneClass> classes);

  std::unique_ptr<Network> network_;
  std::vector<SceneClass> classes_;
};

}  // namespace enfilade::perception

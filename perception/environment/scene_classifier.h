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

// Files of a scene classifier: an ONNX network with 1x3x224x224 inputs and one output per class, such as a Places365
// ResNet18; labels and mapping as in scene_classes.h. This program ships without a network.
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

// Decides whether a photograph was taken indoors or outdoors (map_manager's criterion 3). Not thread-safe: use one per
// thread.
class SceneClassifier {
 public:
  // NOT_FOUND names the missing file and the remedy. INVALID_ARGUMENT: labels or mapping (ParseSceneClasses), a model
  // that OpenCV cannot read, with other inputs than 1x3x224x224 or a number of outputs other than that of the labels.
  static absl::StatusOr<SceneClassifier> Load(const SceneClassifierFiles& files);
  // The same from a model's bytes.
  static absl::StatusOr<SceneClassifier> Make(std::string_view onnx, std::vector<SceneClass> classes);
  ~SceneClassifier();
  SceneClassifier(SceneClassifier&&) noexcept;
  SceneClassifier& operator=(SceneClassifier&&) noexcept;

  // Preprocesses as Places365's demo: scales the image to 256x256 pixels, takes the central 224x224 as RGB in [0, 1],
  // subtracts ImageNet's means and divides by its deviations. Then softmax over the outputs. Outdoors if the outdoor
  // classes have more than half in total. INVALID_ARGUMENT: a malformed frame.
  absl::StatusOr<SceneVerdict> Classify(const ColorFrame& frame);

 private:
  struct Network;
  SceneClassifier(std::unique_ptr<Network> network, std::vector<SceneClass> classes);

  std::unique_ptr<Network> network_;
  std::vector<SceneClass> classes_;
};

}  // namespace enfilade::perception

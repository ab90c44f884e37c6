// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/environment.h"

namespace enfilade::perception {

// One output of a scene classifier.
struct SceneClass {
  std::string name;
  Environment environment = Environment::kIndoor;
};

// Labels: one line per class in the order of the network's outputs, as in Places365's categories_places365.txt: a name
// ("/a/airfield"), optionally followed by a number. Mapping: one line per class in any order, "name 1" (indoor) or
// "name 2" (outdoor) as in Places365's IO_places365.txt, or with the words indoor and outdoor. Empty lines and lines
// that start with # are skipped. INVALID_ARGUMENT naming the line: no class, a duplicate class, a class without
// mapping, another value.
absl::StatusOr<std::vector<SceneClass>> ParseSceneClasses(std::string_view labels, std::string_view mapping);

}  // namespace enfilade::perception

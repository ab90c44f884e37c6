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

// Labels: one line per class in the order of the network's outputs, as Places365's categories_places365.txt: a name
// ("/a/airfield"), which a number may follow. Mapping: one line per class, "name 1" (indoor) or "name 2" (outdoor), as
// Places365's IO_places365.txt, in any order; the words indoor and outdoor are taken too. Empty lines and lines that
// begin with # are passed over. INVALID_ARGUMENT naming the line: no class at all, a class twice, one that is not
// mapped, a value that is neither.
absl::StatusOr<std::vector<SceneClass>> ParseSceneClasses(std::string_view labels, std::string_view mapping);

}  // namespace enfilade::perception

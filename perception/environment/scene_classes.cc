// SPDX-License-Identifier: Apache-2.0
#include "perception/environment/scene_classes.h"

#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::perception {
namespace {

struct Line {
  int number = 0;
  std::string first;
  std::string second;  // empty if there is none
};

std::vector<Line> LinesOf(std::string_view text) {
  std::vector<Line> lines;
  std::istringstream stream{std::string(text)};
  std::string whole;
  for (int number = 1; std::getline(stream, whole); ++number) {
    std::istringstream words(whole);
    Line line{.number = number, .first = {}, .second = {}};
    if (words >> line.first && line.first.front() != '#') {
      words >> line.second;
      lines.push_back(line);
    }
  }
  return lines;
}

std::optional<Environment> EnvironmentOf(const std::string& word) {
  if (word == "1" || word == "indoor") return Environment::kIndoor;
  if (word == "2" || word == "outdoor") return Environment::kOutdoor;
  return std::nullopt;
}

absl::StatusOr<std::map<std::string, Environment>> ParseMapping(std::string_view text) {
  std::map<std::string, Environment> mapping;
  for (const Line& line : LinesOf(text)) {
    const std::optional<Environment> environment = EnvironmentOf(line.second);
    if (!environment) {
      return InvalidArgument("mapping, line {}: \"{} {}\": expected a class and 1 (indoor) or 2 (outdoor)", line.number,
                             line.first, line.second);
    }
    if (!mapping.emplace(line.first, *environment).second) {
      return InvalidArgument("mapping, line {}: duplicate class {}", line.number, line.first);
    }
  }
  return mapping;
}

}  // namespace

absl::StatusOr<std::vector<SceneClass>> ParseSceneClasses(std::string_view labels, std::string_view mapping) {
  ENFILADE_ASSIGN_OR_RETURN(const auto environments, ParseMapping(mapping));
  std::vector<SceneClass> classes;
  std::set<std::string> known;
  for (const Line& line : LinesOf(labels)) {
    if (!known.insert(line.first).second) {
      return InvalidArgument("labels, line {}: duplicate class {}", line.number, line.first);
    }
    const auto found = environments.find(line.first);
    if (found == environments.end()) {
      return InvalidArgument("labels, line {}: the class {} is not in the mapping to indoor and outdoor", line.number,
                             line.first);
    }
    classes.push_back({line.first, found->second});
  }
  if (classes.empty()) return InvalidArgument("labels: no class is named");
  return classes;
}

}  // namespace enfilade::perception

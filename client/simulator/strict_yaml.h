// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/base/error.h"

namespace enfilade::simulator {

// Takes the members of one YAML map by name. The first error of a whole document stays in `status`, with its line;
// after it every getter returns its fallback. `Finish` refuses keys that nobody asked for: a misspelt one must not
// pass.
class StrictMap {
 public:
  StrictMap(const YAML::Node& node, std::string what, absl::Status& status)
      : node_(node), what_(std::move(what)), status_(status) {
    if (!node_.IsMap()) Fail(node_, what_ + " is no map of keys and values");
  }

  YAML::Node Find(const std::string& key) {
    taken_.insert(key);
    return node_.IsMap() ? node_[key] : YAML::Node(YAML::NodeType::Undefined);
  }
  bool Has(const std::string& key) const { return node_.IsMap() && node_[key].IsDefined(); }

  template <typename T>
  T Get(const std::string& key, T fallback) {
    const YAML::Node value = Find(key);
    if (!value.IsDefined()) return fallback;
    T result = fallback;
    if (!value.IsScalar() || !YAML::convert<T>::decode(value, result)) {
      Fail(value, what_ + "." + key + " is no " + TypeName<T>());
      return fallback;
    }
    return result;
  }
  // A finite number within [low, high].
  double Number(const std::string& key, double fallback, double low, double high) {
    const double value = Get<double>(key, fallback);
    if (value >= low && value <= high) return value;
    Fail(Find(key), fmt::format("{}.{} is {}: expected {} to {}", what_, key, value, low, high));
    return fallback;
  }
  template <typename T>
  T Required(const std::string& key) {
    if (!Has(key)) Fail(node_, what_ + "." + key + " is missing");
    return Get<T>(key, T());
  }
  // `count` finite numbers; zeros where missing.
  std::vector<double> Numbers(const std::string& key, std::size_t count) {
    if (!Has(key)) Fail(node_, what_ + "." + key + " is missing");
    return NumbersOf(Find(key), key, count);
  }
  std::vector<double> NumbersOf(const YAML::Node& value, const std::string& key, std::size_t count) {
    std::vector<double> numbers(count, 0.0);
    bool good = value.IsDefined() && value.IsSequence() && value.size() == count;
    for (std::size_t i = 0; good && i < count; ++i) {
      good = YAML::convert<double>::decode(value[i], numbers[i]) && std::abs(numbers[i]) < 1e6;
    }
    if (!good) Fail(value, fmt::format("{}.{}: expected {} numbers", what_, key, count));
    return numbers;
  }
  Eigen::Vector2d Point(const std::string& key) {
    const std::vector<double> numbers = Numbers(key, 2);
    return {numbers[0], numbers[1]};
  }
  std::vector<Eigen::Vector2d> Points(const std::string& key) {
    std::vector<Eigen::Vector2d> points;
    const YAML::Node list = Find(key);
    if (!list.IsDefined() || !list.IsSequence()) {
      Fail(list, what_ + "." + key + ": expected a list of points");
      return points;
    }
    for (const YAML::Node& point : list) {
      const std::vector<double> numbers = NumbersOf(point, key, 2);
      points.emplace_back(numbers[0], numbers[1]);
    }
    return points;
  }
  // Calls visit(element) for each element of a list; nothing where the key is missing.
  template <typename Visit>
  void Each(const std::string& key, Visit visit) {
    const YAML::Node list = Find(key);
    if (!list.IsDefined()) return;
    if (!list.IsSequence()) return Fail(list, what_ + "." + key + " is no list");
    for (const YAML::Node& element : list) visit(element);
  }

  void Finish() {
    if (!node_.IsMap()) return;
    for (const auto& entry : node_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (!taken_.contains(key)) Fail(entry.first, fmt::format("{} has no key \"{}\"", what_, key));
    }
  }
  void Fail(const YAML::Node& where, const std::string& message) {
    if (!status_.ok()) return;
    const int line = where.IsDefined() && where.Mark().line >= 0 ? where.Mark().line : node_.Mark().line;
    status_ = InvalidArgument("line {}: {}", line + 1, message);
  }
  const std::string& what() const { return what_; }

 private:
  template <typename T>
  static const char* TypeName() {
    if constexpr (std::is_same_v<T, bool>) return "true or false";
    if constexpr (std::is_integral_v<T>) return "whole number";
    if constexpr (std::is_floating_point_v<T>) return "number";
    return "text";
  }

  YAML::Node node_;
  std::string what_;
  absl::Status& status_;
  std::set<std::string> taken_;
};

}  // namespace enfilade::simulator

// SPDX-License-Identifier: Apache-2.0
#include "core/options/strict_mapping.h"

#include <cmath>

#include "core/base/error.h"
#include "fmt/ranges.h"

namespace enfilade::yaml_options {
namespace {

constexpr double kLargestNumber = 1e6;

}  // namespace

StrictMapping::StrictMapping(const YAML::Node& node, std::string what, absl::Status& status)
    : node_(node), what_(std::move(what)), status_(status) {
  if (!node_.IsMap()) Fail(node_, what_ + " is not a mapping");
}

YAML::Node StrictMapping::Find(const std::string& key) {
  known_.insert(key);
  return node_.IsMap() ? node_[key] : YAML::Node(YAML::NodeType::Undefined);
}

double StrictMapping::Number(const std::string& key, double fallback, double low, double high) {
  const double value = Get<double>(key, fallback);
  if (value >= low && value <= high) return value;
  Fail(Find(key), fmt::format("{}.{} is {}: expected {} to {}", what_, key, value, low, high));
  return fallback;
}

std::vector<double> StrictMapping::Numbers(const std::string& key, std::size_t count) {
  if (!Has(key)) FailMissing(key);
  return NumbersOf(Find(key), key, count);
}

std::vector<double> StrictMapping::NumbersOf(const YAML::Node& value, const std::string& key, std::size_t count) {
  std::vector<double> numbers(count, 0.0);
  bool good = value.IsDefined() && value.IsSequence() && value.size() == count;
  for (std::size_t i = 0; good && i < count; ++i) {
    good = YAML::convert<double>::decode(value[i], numbers[i]) && std::abs(numbers[i]) < kLargestNumber;
  }
  if (!good) Fail(value, fmt::format("{}.{}: expected {} numbers", what_, key, count));
  return numbers;
}

void StrictMapping::Finish() {
  if (!node_.IsMap()) return;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (!known_.contains(key)) Fail(entry.first, fmt::format("{} has no key \"{}\"", what_, key));
  }
}

void StrictMapping::Fail(const YAML::Node& where, const std::string& message) {
  if (!status_.ok()) return;
  const YAML::Mark mark = where.IsDefined() && where.Mark().line >= 0 ? where.Mark() : node_.Mark();
  status_ = InvalidArgument("{}: {}", Location("", mark), message);
}

void StrictMapping::FailMissing(const std::string& key) { Fail(node_, what_ + "." + key + " is missing"); }

void StrictMapping::FailChoice(const std::string& key, const std::string& word, const std::vector<std::string>& words) {
  Fail(Find(key), fmt::format("{}.{} is \"{}\": expected {}", what_, key, word, fmt::join(words, ", ")));
}

}  // namespace enfilade::yaml_options

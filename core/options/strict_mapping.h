// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <initializer_list>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/options/yaml_document.h"

namespace enfilade::yaml_options {

// Reads the members of one YAML mapping by key, with types and ranges checked. The first error of a document stays in
// the `status` that all its mappings share, as INVALID_ARGUMENT "line 3: area.height is ..."; after it every getter
// returns its fallback, so that a reader can check once at its end. `Finish` refuses the keys that no getter asked for:
// a misspelt key is never ignored.
class StrictMapping {
 public:
  // `what` names the mapping in messages, such as "area".
  StrictMapping(const YAML::Node& node, std::string what, absl::Status& status);

  const std::string& what() const { return what_; }
  bool Has(const std::string& key) const { return node_.IsMap() && node_[key].IsDefined(); }
  // The member, undefined if missing. The key counts as known from then on.
  YAML::Node Find(const std::string& key);

  template <typename T>
  T Get(const std::string& key, T fallback) {
    const YAML::Node value = Find(key);
    if (!value.IsDefined()) return fallback;
    if (auto scalar = ScalarAs<T>(value)) return *std::move(scalar);
    Fail(value, what_ + "." + key + " is not " + TypeName<T>());
    return fallback;
  }
  template <typename T>
  T Required(const std::string& key) {
    if (!Has(key)) FailMissing(key);
    return Get<T>(key, T());
  }
  // A number within [low, high].
  double Number(const std::string& key, double fallback, double low, double high);
  // One of a few words, each with its value.
  template <typename T>
  T Choice(const std::string& key, std::initializer_list<std::pair<const char*, T>> choices, T fallback) {
    if (!Has(key)) return fallback;
    const std::string word = Get<std::string>(key, "");
    std::vector<std::string> words;
    for (const auto& [name, value] : choices) {
      if (word == name) return value;
      words.emplace_back(name);
    }
    FailChoice(key, word, words);
    return fallback;
  }
  // A list of `count` numbers, each within +-1e6; zeros if it is missing or wrong.
  std::vector<double> Numbers(const std::string& key, std::size_t count);
  // The same of `value`, a part of the member `key`.
  std::vector<double> NumbersOf(const YAML::Node& value, const std::string& key, std::size_t count);
  // Calls visit(element) for each element of a list; nothing if the key is missing.
  template <typename Visit>
  void Each(const std::string& key, Visit visit) {
    const YAML::Node list = Find(key);
    if (!list.IsDefined()) return;
    if (!list.IsSequence()) return Fail(list, what_ + "." + key + " is not a list");
    for (const YAML::Node& element : list) visit(element);
  }

  // To be called last.
  void Finish();
  // Records an error at `where`, unless there is one already.
  void Fail(const YAML::Node& where, const std::string& message);

 private:
  void FailMissing(const std::string& key);
  void FailChoice(const std::string& key, const std::string& word, const std::vector<std::string>& words);

  YAML::Node node_;
  std::string what_;
  absl::Status& status_;
  std::set<std::string> known_;
};

}  // namespace enfilade::yaml_options

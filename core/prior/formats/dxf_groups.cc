// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/dxf_groups.h"

#include <charconv>
#include <cmath>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::prior {
namespace {

std::string_view Trimmed(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
}

class DxfSplitter {
 public:
  explicit DxfSplitter(std::string_view text) : text_(text) {}

  absl::StatusOr<DxfFile> Split() {
    while (!AtEnd()) {
      ENFILADE_RETURN_IF_ERROR(ReadGroup());
      Take();
    }
    FinishEntity();
    if (!sectioned_) return InvalidArgument("not a DXF drawing: it has no sections");
    return std::move(file_);
  }

 private:
  bool AtEnd() const { return Trimmed(text_.substr(position_)).empty() || section_ == "EOF"; }

  std::string_view NextLine() {
    const std::size_t end = std::min(text_.find('\n', position_), text_.size());
    const std::string_view line = Trimmed(text_.substr(position_, end - position_));
    position_ = std::min(end + 1, text_.size());
    ++line_;
    return line;
  }

  absl::Status ReadGroup() {
    const std::string_view code = NextLine();
    const auto [end, error] = std::from_chars(code.data(), code.data() + code.size(), group_.code);
    if (error != std::errc() || end != code.data() + code.size() || position_ >= text_.size()) {
      return InvalidArgument("the DXF is damaged or truncated at line {}: expected a group code and a value", line_);
    }
    group_.value = NextLine();
    return absl::OkStatus();
  }

  void Take() {
    if (group_.code == 999) return;  // a comment
    if (group_.code == 0) return Begin();
    if (entity_.type == "SECTION" && group_.code == 2) {
      section_ = group_.value;
      sectioned_ = true;
    }
    if (section_ == "HEADER" && group_.code == 9) variable_ = group_.value;
    if (section_ == "HEADER" && variable_ == "$INSUNITS" && group_.code == 70) {
      file_.insert_units = group_.Number().value_or(0);
    }
    if (section_ == "ENTITIES" || section_ == "BLOCKS") entity_.groups.push_back(group_);
  }

  void Begin() {
    FinishEntity();
    entity_ = {group_.value, {}};
    if (group_.value == "ENDSEC" || group_.value == "EOF") section_ = group_.value;
  }

  void FinishEntity() {
    if (section_ == "ENTITIES" && entity_.type != "SECTION") file_.entities.push_back(std::move(entity_));
    if (section_ != "BLOCKS" || entity_.type == "SECTION") return;
    if (entity_.type == "BLOCK") {
      block_ = std::string(entity_.Text(2));
    } else if (entity_.type != "ENDBLK") {
      file_.blocks[block_].push_back(std::move(entity_));
    }
  }

  std::string_view text_;
  std::size_t position_ = 0;
  int line_ = 0;
  DxfGroup group_;
  DxfEntity entity_;
  std::string_view section_, variable_;
  std::string block_;
  bool sectioned_ = false;
  DxfFile file_;
};

}  // namespace

std::optional<double> DxfGroup::Number() const {
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::string_view DxfEntity::Text(int code) const {
  for (const DxfGroup& group : groups) {
    if (group.code == code) return group.value;
  }
  return {};
}

double DxfEntity::Number(int code, double otherwise) const {
  for (const DxfGroup& group : groups) {
    if (group.code == code) return group.Number().value_or(otherwise);
  }
  return otherwise;
}

absl::StatusOr<DxfFile> SplitDxf(std::string_view text) {
  if (text.substr(0, 18) == "AutoCAD Binary DXF") {
    return InvalidArgument("binary DXF is not read: save the drawing as ASCII DXF");
  }
  return DxfSplitter(text).Split();
}

}  // namespace enfilade::prior

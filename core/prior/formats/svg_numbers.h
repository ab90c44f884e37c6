// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

namespace enfilade::prior {

// Reads SVG's lists of numbers and of letters with numbers (points, transforms, path data).
class SvgScanner {
 public:
  explicit SvgScanner(std::string_view text) : text_(text) {}

  bool AtEnd() {
    SkipSpace();
    return text_.empty();
  }
  // The next letter, if there is one.
  std::optional<char> Letter() {
    SkipSpace();
    if (text_.empty() || !std::isalpha(static_cast<unsigned char>(text_[0]))) return std::nullopt;
    const char letter = text_[0];
    text_.remove_prefix(1);
    return letter;
  }
  std::optional<double> Number() {
    SkipSpace();
    std::string_view rest = text_;
    if (!rest.empty() && rest[0] == '+') rest.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return number;
  }
  // 0 or 1, which need no space behind them.
  std::optional<bool> Flag() {
    SkipSpace();
    if (text_.empty() || (text_[0] != '0' && text_[0] != '1')) return std::nullopt;
    const bool flag = text_[0] == '1';
    text_.remove_prefix(1);
    return flag;
  }
  std::optional<Eigen::Vector2d> Point() {
    const auto x = Number();
    const auto y = x ? Number() : std::nullopt;
    if (!y) return std::nullopt;
    return Eigen::Vector2d(*x, *y);
  }

 private:
  void SkipSpace() {
    while (!text_.empty() && (std::isspace(static_cast<unsigned char>(text_[0])) || text_[0] == ',')) {
      text_.remove_prefix(1);
    }
  }
  std::string_view text_;
};

// A number with or without a unit, which is ignored; `otherwise` if there is none.
inline double SvgNumber(std::string_view text, double otherwise) {
  return SvgScanner(text).Number().value_or(otherwise);
}

// "translate(3 4) rotate(90)"; the identity up to the first fault.
Eigen::Affine2d SvgTransform(std::string_view text);

struct SvgSubpath {
  std::vector<Eigen::Vector2d> points;
  bool closed = false;
};

// Path data with curves and arcs as chords, up to the first fault.
std::vector<SvgSubpath> SvgPath(std::string_view text);

}  // namespace enfilade::prior

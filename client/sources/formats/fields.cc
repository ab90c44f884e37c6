// SPDX-License-Identifier: Apache-2.0
#include "client/sources/formats/fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::sources {
namespace {

constexpr std::string_view kBlank = " \t\f";

// from_chars accepts no leading plus sign; logs written with printf("%+f") have one.
std::string_view WithoutPlus(std::string_view text) { return text.starts_with('+') ? text.substr(1) : text; }

template <typename T>
bool Parse(std::string_view text, T& value) {
  text = WithoutPlus(text);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  // Denormal and smaller numbers are reported as out of range. Logs contain such garbage instead of zero.
  if constexpr (std::is_floating_point_v<T>) {
    if (error == std::errc::result_out_of_range && stop == end && text.find("e-") != std::string_view::npos) {
      value = 0;
      return true;
    }
  }
  return error == std::errc() && stop == end && !text.empty();
}

std::string Excerpt(std::string_view text) {
  constexpr std::size_t kMost = 40;
  return std::string(text.substr(0, kMost)) + (text.size() > kMost ? "..." : "");
}

bool IsDigits(std::string_view text) { return text.find_first_not_of("0123456789") == std::string_view::npos; }

}  // namespace

void Fields::Fail(const std::string& message) {
  if (status_.ok()) status_ = absl::InvalidArgumentError(message);
}

std::string_view Fields::Word(std::string_view name) {
  if (!ok()) return {};
  const std::size_t begin = rest_.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) {
    rest_ = {};
    Fail(fmt::format("the line ends before field {} ({})", position_ + 1, name));
    return {};
  }
  const std::size_t end = rest_.find_first_of(kBlank, begin);
  const std::string_view word = rest_.substr(begin, end == std::string_view::npos ? end : end - begin);
  rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end);
  ++position_;
  return word;
}

double Fields::Number(std::string_view name) {
  const std::string_view word = Word(name);
  double value = 0.0;
  if (ok() && !Parse(word, value)) {
    Fail(fmt::format("field {} ({}) is \"{}\": expected a number", position_, name, Excerpt(word)));
  } else if (ok() && !std::isfinite(value)) {
    Fail(fmt::format("field {} ({}) is {}: expected a finite number", position_, name, value));
  }
  return ok() ? value : 0.0;
}

std::int64_t Fields::Integer(std::string_view name) {
  const std::string_view word = Word(name);
  std::int64_t value = 0;
  if (ok() && !Parse(word, value)) {
    Fail(fmt::format("field {} ({}) is \"{}\": expected an integer", position_, name, Excerpt(word)));
  }
  return ok() ? value : 0;
}

TimeNs Fields::Seconds(std::string_view name) {
  const std::string_view word = Word(name);
  TimeNs time = 0;
  if (ok() && !ParseSeconds(word, time)) {
    Fail(fmt::format("field {} ({}) is \"{}\": expected seconds", position_, name, Excerpt(word)));
  }
  return ok() ? time : 0;
}

Pose2 Fields::Pose(std::string_view name, double metres_per_unit) {
  const std::string base(name);
  const double x = Number(base + ".x");
  const double y = Number(base + ".y");
  return {x * metres_per_unit, y * metres_per_unit, Number(base + ".theta")};
}

std::vector<float> Fields::Ranges(std::string_view name, std::int64_t count, double scale) {
  if (!ok()) return {};
  if (count < 1 || count > static_cast<std::int64_t>(sensor::kMaxBeams)) {
    Fail(fmt::format("field {} (number of {}) is {}: expected 1 to {}", position_, name, count, sensor::kMaxBeams));
    return {};
  }
  std::vector<float> ranges;
  ranges.reserve(static_cast<std::size_t>(count));
  while (ok() && static_cast<std::int64_t>(ranges.size()) < count) {
    const std::string_view word = Word(name);
    double value = 0.0;
    if (ok() && !Parse(word, value)) {
      Fail(fmt::format("field {} ({} {} of {}) is \"{}\": expected a number", position_, name, ranges.size() + 1, count,
                       Excerpt(word)));
    }
    ranges.push_back(static_cast<float>(value * scale));
  }
  return ranges;
}

void Fields::Skip(std::string_view name, std::int64_t count) {
  for (std::int64_t i = 0; i < count && ok(); ++i) Word(name);
}

void Fields::ExpectRemaining(std::int64_t count, const std::string& reason) {
  if (!ok()) return;
  std::int64_t remaining = 0;
  for (std::size_t at = 0; (at = rest_.find_first_not_of(kBlank, at)) != std::string_view::npos; ++remaining) {
    at = std::min(rest_.find_first_of(kBlank, at), rest_.size());
  }
  if (remaining == count) return;
  Fail(fmt::format("{}: the line needs {} fields and has {}", reason, position_ + count, position_ + remaining));
}

void Fields::ExpectEnd() {
  if (ok() && rest_.find_first_not_of(kBlank) != std::string_view::npos) {
    Fail(fmt::format("fields follow after the last one expected ({})", position_));
  }
}

bool ParseSeconds(std::string_view text, TimeNs& time) {
  text = WithoutPlus(text);
  const bool negative = text.starts_with('-');
  const std::string_view digits = negative ? text.substr(1) : text;
  const std::size_t point = digits.find('.');
  const std::string_view whole = digits.substr(0, point);
  const std::string_view fraction = point == std::string_view::npos ? std::string_view() : digits.substr(point + 1);
  if (!IsDigits(whole) || !IsDigits(fraction) || whole.size() + fraction.size() == 0) {
    double seconds = 0.0;
    if (!Parse(text, seconds) || !(std::abs(seconds) < 9.2e9)) return false;
    time = static_cast<TimeNs>(std::llround(seconds * 1e9));
    return true;
  }
  std::int64_t seconds = 0;
  if (!whole.empty() && !Parse(whole, seconds)) return false;
  if (seconds > 9'200'000'000) return false;
  std::int64_t nanoseconds = 0;
  for (std::size_t i = 0; i < 9; ++i) nanoseconds = nanoseconds * 10 + (i < fraction.size() ? fraction[i] - '0' : 0);
  if (fraction.size() > 9 && fraction[9] >= '5') ++nanoseconds;
  time = seconds * kNsPerSecond + nanoseconds;
  if (negative) time = -time;
  return true;
}

}  // namespace enfilade::sources

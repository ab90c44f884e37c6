// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/json_map.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/json_scanner.h"

namespace enfilade::grid {
namespace {

// Tolerance of a side's length in cells: limits are often printed with few digits.
constexpr double kSideTolerance = 0.01;

constexpr std::array<std::pair<std::string_view, double UnitLimits::*>, 7> kFields = {{
    {"xmin", &UnitLimits::xmin},
    {"xmax", &UnitLimits::xmax},
    {"ymin", &UnitLimits::ymin},
    {"ymax", &UnitLimits::ymax},
    {"stepx", &UnitLimits::stepx},
    {"stepy", &UnitLimits::stepy},
    {"level", &UnitLimits::level},
}};

class Parser {
 public:
  explicit Parser(std::string_view text) : scanner_(text) {}

  absl::Status Parse() {
    ENFILADE_RETURN_IF_ERROR(scanner_.Expect('{'));
    if (!scanner_.Accept('}')) {
      do {
        ENFILADE_RETURN_IF_ERROR(Member());
      } while (scanner_.Accept(','));
      ENFILADE_RETURN_IF_ERROR(scanner_.Expect('}'));
    }
    ENFILADE_RETURN_IF_ERROR(scanner_.ExpectEnd());
    for (std::size_t i = 0; i < kFields.size(); ++i) {
      if (!has_field_[i]) return InvalidArgument("the JSON map has no '{}'", kFields[i].first);
    }
    return has_data_ ? absl::OkStatus() : InvalidArgument("the JSON map has no 'data'");
  }

  const UnitLimits& limits() const { return limits_; }
  std::vector<double>& values() { return values_; }
  std::vector<std::string>& warnings() { return warnings_; }

 private:
  absl::Status Member() {
    ENFILADE_ASSIGN_OR_RETURN(std::string_view key, scanner_.String());
    ENFILADE_RETURN_IF_ERROR(scanner_.Expect(':'));
    if (key == "data") return Data();
    if (key == "Level") key = "level";
    for (std::size_t i = 0; i < kFields.size(); ++i) {
      if (key == kFields[i].first) return Field(i);
    }
    warnings_.push_back(fmt::format("the JSON map's '{}' is unknown and ignored", key));
    return scanner_.SkipValue();
  }

  absl::Status Field(std::size_t index) {
    const auto& [name, member] = kFields[index];
    if (std::exchange(has_field_[index], true)) return scanner_.ErrorHere(fmt::format("'{}' is given twice", name));
    ENFILADE_ASSIGN_OR_RETURN(limits_.*member, WithName(scanner_.Number(), fmt::format("the JSON map's '{}'", name)));
    return absl::OkStatus();
  }

  absl::Status Data() {
    if (std::exchange(has_data_, true)) return scanner_.ErrorHere("'data' is given twice");
    if (!scanner_.Accept('[')) return scanner_.ErrorHere("the JSON map's 'data' is not an array");
    if (scanner_.Accept(']')) return absl::OkStatus();
    // A cell takes at least about two characters, so this is never more than a few times the text.
    values_.reserve(std::min(ExpectedCells(), scanner_.remaining() / 2 + 1));
    do {
      const absl::StatusOr<double> value = scanner_.Number();
      if (!value.ok()) return WithContext(value.status(), fmt::format("the JSON map's data[{}]", values_.size()));
      if (!(*value >= 0.0 && *value <= 1.0)) {
        return scanner_.ErrorHere(
            fmt::format("the JSON map's data[{}] is {}: expected 0 to 1", values_.size(), *value));
      }
      if (static_cast<std::int64_t>(values_.size()) == kMaxRasterCells) {
        return scanner_.ErrorHere(
            fmt::format("the JSON map has more than {} data, which is not supported", kMaxRasterCells));
      }
      values_.push_back(*value);
    } while (scanner_.Accept(','));
    return WithContext(scanner_.Expect(']'), fmt::format("the JSON map's data[{}]", values_.size()));
  }

  // From the limits if they precede the data, otherwise 0.
  std::size_t ExpectedCells() const {
    const double columns = (limits_.xmax - limits_.xmin) / limits_.stepx + 1.0;
    const double rows = (limits_.ymax - limits_.ymin) / limits_.stepy + 1.0;
    const double cells = columns * rows;
    return cells >= 1.0 && cells <= static_cast<double>(kMaxRasterCells) ? static_cast<std::size_t>(cells) : 0;
  }

  static absl::StatusOr<double> WithName(absl::StatusOr<double> value, const std::string& name) {
    if (!value.ok()) return WithContext(value.status(), name);
    return value;
  }

  JsonScanner scanner_;
  UnitLimits limits_;
  std::array<bool, kFields.size()> has_field_{};
  bool has_data_ = false;
  std::vector<double> values_;
  std::vector<std::string> warnings_;
};

// (max - min) / step, which must be a whole number within the tolerance.
absl::StatusOr<std::int64_t> Intervals(std::string_view axis, double min, double max, double step) {
  if (!(step > 0.0)) return InvalidArgument("the JSON map's step{} is {}: expected positive metres", axis, step);
  const double intervals = (max - min) / step;
  if (!(intervals >= 0.0) || intervals > static_cast<double>(kMaxRasterCells)) {
    return InvalidArgument("the JSON map's {0}min {1} and {0}max {2} do not hold 1 to {3} cells of step{0} {4}", axis,
                           min, max, kMaxRasterCells, step);
  }
  if (std::abs(intervals - std::round(intervals)) > kSideTolerance) {
    return InvalidArgument("the JSON map's {0}max - {0}min is {1}, not a multiple of step{0} {2}", axis, max - min,
                           step);
  }
  return std::llround(intervals);
}

absl::StatusOr<GridGeometry> GeometryOf(const UnitLimits& limits, std::size_t data_count) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t columns, Intervals("x", limits.xmin, limits.xmax, limits.stepx));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t rows, Intervals("y", limits.ymin, limits.ymax, limits.stepy));
  if (std::abs(limits.stepx - limits.stepy) > 1e-9 * limits.stepx) {
    return InvalidArgument("the JSON map's stepx {} and stepy {} differ: its cells must be square", limits.stepx,
                           limits.stepy);
  }
  const auto count = static_cast<std::int64_t>(data_count);
  // Both below 2^28 + 2: the products fit.
  const bool limits_are_centres = count == (columns + 1) * (rows + 1);
  if (!limits_are_centres && (count != columns * rows || count == 0)) {
    return InvalidArgument(
        "the JSON map's data has {} numbers: its limits and steps make {} x {} = {} cells (limits at the outer cells' "
        "centres) or {} x {} = {} (at their edges)",
        data_count, columns + 1, rows + 1, (columns + 1) * (rows + 1), columns, rows, columns * rows);
  }
  const double half = limits_are_centres ? limits.stepx / 2.0 : 0.0;
  GridGeometry geometry;
  geometry.resolution = limits.stepx;
  geometry.T_map_grid = {limits.xmin - half, limits.ymin - half, 0.0};
  geometry.width = static_cast<int>(columns + (limits_are_centres ? 1 : 0));
  geometry.height = static_cast<int>(rows + (limits_are_centres ? 1 : 0));
  return geometry;
}

void AppendNumber(double value, std::string& out) {
  std::array<char, 32> buffer;
  const std::to_chars_result result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  out.append(buffer.data(), result.ptr);
}

// One number per line, as the format's reference writer.
template <typename Append>
std::string Format(const UnitLimits& limits, std::size_t count, std::size_t bytes_per_cell, Append append) {
  std::string out;
  out.reserve(256 + count * bytes_per_cell);
  out += "{\n";
  for (const auto& [name, member] : kFields) {
    out += fmt::format("  \"{}\": ", name);
    AppendNumber(limits.*member, out);
    out += ",\n";
  }
  out += "  \"data\": [";
  for (std::size_t i = 0; i < count; ++i) {
    out += i == 0 ? "\n" : ",\n";
    append(i, out);
  }
  out += "\n  ]\n}\n";
  return out;
}

}  // namespace

absl::StatusOr<ParsedJsonMap> ParseJsonMap(std::string_view text) {
  Parser parser(text);
  ENFILADE_RETURN_IF_ERROR(parser.Parse());
  ParsedJsonMap parsed;
  ENFILADE_ASSIGN_OR_RETURN(parsed.raster.geometry, GeometryOf(parser.limits(), parser.values().size()));
  ENFILADE_RETURN_IF_ERROR(Validate(parsed.raster.geometry));
  parsed.raster.cells = UnitCells{std::move(parser.values()), parser.limits()};
  parsed.warnings = std::move(parser.warnings());
  return parsed;
}

absl::StatusOr<UnitLimits> UnitLimitsOf(const GridGeometry& geometry, double level) {
  const Pose2& origin = geometry.T_map_grid;
  if (origin.yaw != 0.0) {
    return InvalidArgument("the map's origin has the yaw {} rad, which a JSON map cannot express: export PGM or PNG",
                           origin.yaw);
  }
  const double half = geometry.resolution / 2.0;
  UnitLimits limits;
  limits.xmin = origin.x + half;
  limits.xmax = limits.xmin + (geometry.width - 1) * geometry.resolution;
  limits.ymin = origin.y + half;
  limits.ymax = limits.ymin + (geometry.height - 1) * geometry.resolution;
  limits.stepx = geometry.resolution;
  limits.stepy = geometry.resolution;
  limits.level = level;
  return limits;
}

std::string FormatJsonMap(const UnitLimits& limits, std::span<const double> values) {
  return Format(limits, values.size(), 12, [&](std::size_t i, std::string& out) { AppendNumber(values[i], out); });
}

std::string FormatJsonMap(const UnitLimits& limits, std::span<const std::uint8_t> cells) {
  std::array<std::string, 256> words;
  words[kUnknownCell] = "0.5";
  for (std::size_t cell = 1; cell < words.size(); ++cell) {
    AppendNumber(std::round(ProbabilityOfCell(static_cast<std::uint8_t>(cell)) * 1e4) / 1e4, words[cell]);
  }
  return Format(limits, cells.size(), 5, [&](std::size_t i, std::string& out) { out += words[cells[i]]; });
}

}  // namespace enfilade::grid

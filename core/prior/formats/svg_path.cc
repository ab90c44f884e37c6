// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>

#include "core/prior/formats/plan_lines.h"
#include "core/prior/formats/svg_numbers.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

class SvgPathReader {
 public:
  explicit SvgPathReader(std::string_view text) : scanner_(text) {}

  std::vector<SvgSubpath> Read() {
    char command = 0;
    while (!scanner_.AtEnd()) {
      if (const auto letter = scanner_.Letter()) {
        command = *letter;
      } else if (command == 0) {
        break;
      }
      if (!Take(command)) break;
      // Further points of a move are lines; a closed path needs a new letter.
      if (command == 'M') command = 'L';
      if (command == 'm') command = 'l';
      if (command == 'Z' || command == 'z') command = 0;
    }
    std::erase_if(subpaths_, [](const SvgSubpath& subpath) { return subpath.points.size() < 2; });
    return std::move(subpaths_);
  }

 private:
  static constexpr int kChords = 12;  // of a curve

  std::optional<Vector2d> Point(bool relative) {
    const auto point = scanner_.Point();
    if (!point) return std::nullopt;
    return relative ? Vector2d(*point + here_) : *point;
  }

  void GoTo(const Vector2d& point) {
    if (subpaths_.empty() || subpaths_.back().closed) {
      subpaths_.push_back({{here_}, false});
    }
    subpaths_.back().points.push_back(point);
    here_ = point;
  }

  bool Take(char command) {
    const bool relative = std::islower(static_cast<unsigned char>(command)) != 0;
    const char upper = static_cast<char>(std::toupper(static_cast<unsigned char>(command)));
    if (upper != 'C' && upper != 'S') last_cubic_.reset();
    if (upper != 'Q' && upper != 'T') last_quadratic_.reset();
    switch (upper) {
      case 'M':
        return Move(relative);
      case 'L': {
        const auto point = Point(relative);
        if (point) GoTo(*point);
        return point.has_value();
      }
      case 'H':
      case 'V':
        return Straight(upper == 'H', relative);
      case 'Z':
        return Close();
      case 'C':
      case 'S':
        return Cubic(upper == 'S', relative);
      case 'Q':
      case 'T':
        return Quadratic(upper == 'T', relative);
      case 'A':
        return Arc(relative);
      default:
        return false;
    }
  }

  bool Move(bool relative) {
    const auto point = Point(relative);
    if (!point) return false;
    here_ = *point;
    subpaths_.push_back({{here_}, false});
    return true;
  }

  bool Straight(bool horizontal, bool relative) {
    const auto number = scanner_.Number();
    if (!number) return false;
    Vector2d to = here_;
    double& coordinate = horizontal ? to.x() : to.y();
    coordinate = relative ? coordinate + *number : *number;
    GoTo(to);
    return true;
  }

  bool Close() {
    if (subpaths_.empty()) return false;
    subpaths_.back().closed = true;
    here_ = subpaths_.back().points.front();
    return true;
  }

  bool Cubic(bool smooth, bool relative) {
    const auto b =
        smooth ? std::optional<Vector2d>(last_cubic_ ? Vector2d(2 * here_ - *last_cubic_) : here_) : Point(relative);
    const auto c = b ? Point(relative) : std::nullopt;
    const auto d = c ? Point(relative) : std::nullopt;
    if (!d) return false;
    const Vector2d a = here_;
    for (int i = 1; i <= kChords; ++i) {
      const double t = static_cast<double>(i) / kChords, s = 1 - t;
      GoTo(s * s * s * a + 3 * s * s * t * *b + 3 * s * t * t * *c + t * t * t * *d);
    }
    last_cubic_ = *c;
    return true;
  }

  bool Quadratic(bool smooth, bool relative) {
    const auto b = smooth ? std::optional<Vector2d>(last_quadratic_ ? Vector2d(2 * here_ - *last_quadratic_) : here_)
                          : Point(relative);
    const auto c = b ? Point(relative) : std::nullopt;
    if (!c) return false;
    const Vector2d a = here_;
    for (int i = 1; i <= kChords; ++i) {
      const double t = static_cast<double>(i) / kChords, s = 1 - t;
      GoTo(s * s * a + 2 * s * t * *b + t * t * *c);
    }
    last_quadratic_ = *b;
    return true;
  }

  // From the ends to the centre: SVG 1.1, appendix F.6.5.
  bool Arc(bool relative) {
    const auto radii_given = scanner_.Point();
    const auto turn = radii_given ? scanner_.Number() : std::nullopt;
    const auto large = turn ? scanner_.Flag() : std::nullopt;
    const auto clockwise = large ? scanner_.Flag() : std::nullopt;
    const auto end = clockwise ? Point(relative) : std::nullopt;
    if (!end) return false;
    const Vector2d a = here_;
    Vector2d radii = radii_given->cwiseAbs();
    if (radii.minCoeff() <= 0 || (*end - a).norm() == 0) {
      GoTo(*end);
      return true;
    }
    const Eigen::Rotation2Dd rotation(*turn * M_PI / 180);
    const Vector2d half = rotation.inverse() * ((a - *end) / 2);
    const double needed = half.cwiseQuotient(radii).squaredNorm();
    if (needed > 1) radii *= std::sqrt(needed);
    const double share = std::max(0.0, 1 / std::max(half.cwiseQuotient(radii).squaredNorm(), 1e-300) - 1);
    const double sign = *large == *clockwise ? -1 : 1;
    const Vector2d centre =
        sign * std::sqrt(share) * Vector2d(radii.x() * half.y() / radii.y(), -radii.y() * half.x() / radii.x());
    const auto angle = [&](const Vector2d& p) {
      return std::atan2((p.y() - centre.y()) / radii.y(), (p.x() - centre.x()) / radii.x());
    };
    const double from = angle(half);
    double sweep = std::remainder(angle(-half) - from, 2 * M_PI);
    if (*clockwise && sweep < 0) sweep += 2 * M_PI;
    if (!*clockwise && sweep > 0) sweep -= 2 * M_PI;
    const Vector2d middle = (a + *end) / 2;
    const std::vector<Vector2d> chords = ChordsOf(radii, from, sweep, 0);
    for (std::size_t i = 1; i + 1 < chords.size(); ++i) GoTo(middle + rotation * (centre + (chords[i])));
    GoTo(*end);
    return true;
  }

  SvgScanner scanner_;
  Vector2d here_ = Vector2d::Zero();
  std::optional<Vector2d> last_cubic_, last_quadratic_;
  std::vector<SvgSubpath> subpaths_;
};

}  // namespace

std::vector<SvgSubpath> SvgPath(std::string_view text) { return SvgPathReader(text).Read(); }

Eigen::Affine2d SvgTransform(std::string_view text) {
  Eigen::Affine2d T = Eigen::Affine2d::Identity();
  while (true) {
    const std::size_t open = text.find('('), close = text.find(')');
    if (open == std::string_view::npos || close == std::string_view::npos || close < open) return T;
    std::string_view name = text.substr(0, open);
    while (!name.empty() && !std::isalpha(static_cast<unsigned char>(name.front()))) name.remove_prefix(1);
    while (!name.empty() && !std::isalpha(static_cast<unsigned char>(name.back()))) name.remove_suffix(1);
    SvgScanner scanner(text.substr(open + 1, close - open - 1));
    std::vector<double> n;
    while (const auto number = scanner.Number()) n.push_back(*number);
    if (name == "translate" && !n.empty()) {
      T.translate(Vector2d(n[0], n.size() > 1 ? n[1] : 0));
    } else if (name == "scale" && !n.empty()) {
      T.scale(Vector2d(n[0], n.size() > 1 ? n[1] : n[0]));
    } else if (name == "rotate" && !n.empty()) {
      const Vector2d centre = n.size() > 2 ? Vector2d(n[1], n[2]) : Vector2d(0, 0);
      T.translate(centre).rotate(n[0] * M_PI / 180).translate(-centre);
    } else if (name == "skewX" && !n.empty()) {
      T.shear(std::tan(n[0] * M_PI / 180), 0);
    } else if (name == "skewY" && !n.empty()) {
      T.shear(0, std::tan(n[0] * M_PI / 180));
    } else if (name == "matrix" && n.size() >= 6) {
      Eigen::Affine2d M = Eigen::Affine2d::Identity();
      M.linear() << n[0], n[2], n[1], n[3];
      M.translation() << n[4], n[5];
      T = T * M;
    }
    text.remove_prefix(close + 1);
  }
}

}  // namespace enfilade::prior

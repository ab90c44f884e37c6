// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "core/prior/plan/segment_grid.h"
#include "perception/plan/opencv_ink.h"

namespace enfilade::perception {
namespace {

using Eigen::Vector2d;

// A connected part of the ink that is a bar, or a dot.
struct Dash {
  int label = 0;
  Vector2d middle = Vector2d::Zero();
  Vector2d axis = Vector2d::UnitX();
  double length = 0;  // px
  double width = 0;   // px

  bool IsDot() const { return length < 2.5 * width; }
  Vector2d End(int side) const { return middle + (side == 0 ? -0.5 : 0.5) * length * axis; }
  Vector2d Outward(int side) const { return side == 0 ? Vector2d(-axis) : axis; }
};

struct PartSums {
  double area = 0;
  Vector2d sum = Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Vector2d mean = Vector2d::Zero(), axis = Vector2d::UnitX();
  double low = 1e300, high = -1e300, aside = 0;  // along the axis from the mean, and across it

  void FindAxis() {
    mean = sum / area;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(squares / area - mean * mean.transpose());
    axis = solver.eigenvectors().col(1);
  }
  void Extend(const Vector2d& p) {
    const double along = (p - mean).dot(axis);
    low = std::min(low, along);
    high = std::max(high, along);
    aside = std::max(aside, std::abs((p - mean).x() * axis.y() - (p - mean).y() * axis.x()));
  }
};

template <typename Use>
void ForEachLabelled(const cv::Mat& labels, const Use& use) {
  for (int y = 0; y < labels.rows; ++y) {
    const int* row = labels.ptr<int>(y);
    for (int x = 0; x < labels.cols; ++x) {
      if (row[x] > 0) use(row[x], Vector2d(x, y));
    }
  }
}

std::optional<Dash> AsDash(int label, const PartSums& part, double longest) {
  const double length = part.high - part.low + 1;
  const double width = part.area / length;
  constexpr double kBend = 0.08;  // of the length: a dash goes around a corner of what it bounds
  const double straight = std::max(0.8 * width + 1.5, kBend * length);
  if (length > longest || part.area < 4 || part.aside > straight) return std::nullopt;
  return Dash{label, part.mean + (part.low + part.high) / 2 * part.axis, part.axis, length, width};
}

std::vector<Dash> DashesAmong(const cv::Mat& labels, int count, double longest) {
  std::vector<PartSums> parts(count);
  ForEachLabelled(labels, [&](int label, const Vector2d& p) {
    parts[label].area += 1;
    parts[label].sum += p;
    parts[label].squares += p * p.transpose();
  });
  for (int label = 1; label < count; ++label) parts[label].FindAxis();
  ForEachLabelled(labels, [&](int label, const Vector2d& p) { parts[label].Extend(p); });
  std::vector<Dash> dashes;
  for (int label = 1; label < count; ++label) {
    if (const std::optional<Dash> dash = AsDash(label, parts[label], longest)) dashes.push_back(*dash);
  }
  return dashes;
}

struct Link {
  int one = 0, other = 0;
  double gap = 0;  // px
};

// Which dash follows on which.
class DashLinks {
 public:
  DashLinks(const std::vector<Dash>& dashes, double widest_gap)
      : dashes_(dashes), widest_gap_(widest_gap), grid_(widest_gap) {
    for (int i = 0; i < static_cast<int>(dashes.size()); ++i) {
      grid_.Add(2 * i, dashes[i].End(0), dashes[i].End(0));
      grid_.Add(2 * i + 1, dashes[i].End(1), dashes[i].End(1));
    }
  }

  std::vector<Link> Find() const {
    constexpr double kMostPairs = 3e7;
    std::vector<Link> links;
    if (grid_.CountPairs() > kMostPairs) return links;
    std::vector<std::optional<Link>> next(2 * dashes_.size());
    std::vector<int> facing(2 * dashes_.size(), -1);
    for (int end = 0; end < static_cast<int>(next.size()); ++end) {
      if (!dashes_[end / 2].IsDot()) next[end] = NextAfter(end, facing[end]);
    }
    for (int end = 0; end < static_cast<int>(next.size()); ++end) {
      if (!next[end]) continue;
      // Two dashes are each other's next; a dot has no direction.
      const bool mutual = facing[facing[end]] == end;
      if (dashes_[next[end]->other].IsDot() || (mutual && end < facing[end])) links.push_back(*next[end]);
    }
    return links;
  }

 private:
  std::optional<Link> NextAfter(int end, int& facing) const {
    const int i = end / 2;
    const Dash& dash = dashes_[i];
    const Vector2d from = dash.End(end % 2), outward = dash.Outward(end % 2);
    std::optional<Link> next;
    grid_.ForEachNear(from, from, [&](int other_end) {
      const int j = other_end / 2;
      if (j == i || !GoesOn(dash, dashes_[j])) return;
      const Vector2d gap = dashes_[j].End(other_end % 2) - from;
      const double along = gap.dot(outward), aside = std::abs(gap.x() * outward.y() - gap.y() * outward.x());
      if (along <= 0 || along > std::min(widest_gap_, std::max(dash.length, dashes_[j].length))) return;
      constexpr double kAside = 0.35;  // of the gap
      if (aside > std::max(kAside * along, 0.7 * dash.width)) return;
      if (next && next->gap <= along) return;
      next = Link{i, j, along};
      facing = other_end;
    });
    return next;
  }

  static bool GoesOn(const Dash& dash, const Dash& other) {
    constexpr double kWidths = 1.6, kStraight = 0.94;  // the cosine of 20 degrees
    const double thin = std::min(dash.width, other.width), wide = std::max(dash.width, other.width);
    if (wide > kWidths * thin + 1) return false;
    return other.IsDot() || std::abs(dash.axis.dot(other.axis)) > kStraight;
  }

  const std::vector<Dash>& dashes_;
  const double widest_gap_;
  prior::SegmentGrid grid_;
};

// The dashes of dashed lines: many in a row, with gaps that are alike and shorter than they are.
std::vector<Dash> InDashedLines(const std::vector<Dash>& dashes, const std::vector<Link>& links) {
  std::vector<int> line(dashes.size());
  std::iota(line.begin(), line.end(), 0);
  const auto line_of = [&](int i) {
    while (line[i] != i) i = line[i] = line[line[i]];
    return i;
  };
  for (const Link& link : links) line[line_of(link.one)] = line_of(link.other);
  std::vector<std::vector<double>> gaps(dashes.size());
  std::vector<int> bars(dashes.size(), 0), parts(dashes.size(), 0);
  for (const Link& link : links) gaps[line_of(link.one)].push_back(link.gap);
  for (int i = 0; i < static_cast<int>(dashes.size()); ++i) {
    ++parts[line_of(i)];
    if (!dashes[i].IsDot()) ++bars[line_of(i)];
  }
  const auto is_dashed = [&](int i) {
    constexpr int kFewestParts = 5, kFewestBars = 3;
    constexpr double kAlike = 1.6, kMostAlike = 0.7;
    std::vector<double>& all = gaps[i];
    if (parts[i] < kFewestParts || bars[i] < kFewestBars) return false;
    std::nth_element(all.begin(), all.begin() + static_cast<long>(all.size() / 2), all.end());
    const double usual = all[all.size() / 2];
    const auto alike = std::count_if(
        all.begin(), all.end(), [&](double gap) { return gap <= kAlike * usual + 1 && usual <= kAlike * gap + 1; });
    return static_cast<double>(alike) >= kMostAlike * static_cast<double>(all.size());
  };
  std::vector<Dash> dashed;
  for (int i = 0; i < static_cast<int>(dashes.size()); ++i) {
    if (is_dashed(line_of(i))) dashed.push_back(dashes[i]);
  }
  return dashed;
}

// The longer parts of a mask: where thin walls meet, there are small ones that are as wide as a wide pen.
cv::Mat LongPartsOf(const cv::Mat& mask, double least_area) {
  cv::Mat labels, stats, centres;
  cv::connectedComponentsWithStats(mask, labels, stats, centres, 8);
  cv::Mat parts = cv::Mat::zeros(mask.size(), CV_8U);
  ForEachLabelled(labels, [&](int label, const Vector2d& p) {
    if (stats.at<int>(label, cv::CC_STAT_AREA) >= least_area) {
      parts.at<uchar>(static_cast<int>(p.y()), static_cast<int>(p.x())) = 255;
    }
  });
  return parts;
}

// A pen that draws mostly dashed lines draws no walls: where such a line goes around a corner, it has no gaps.
void ErasePenOf(const std::vector<Dash>& dashed, cv::Mat& strokes) {
  double widest = 0, area = 0;
  for (const Dash& dash : dashed) widest = std::max(widest, dash.width);
  for (const Dash& dash : dashed) area += dash.width > 0.6 * widest ? dash.width * dash.length : 0;
  constexpr double kThinnest = 5;  // px; thinner pens cannot be told apart so
  if (widest < kThinnest) return;
  constexpr double kHalf = 0.4, kShortest = 1.5;  // of the pen's width
  cv::Mat wide = LongPartsOf(WidePartsOf(strokes, kHalf * widest), kShortest * widest * widest);
  if (cv::countNonZero(wide) > area) return;
  cv::dilate(wide, wide, cv::Mat::ones(3, 3, CV_8U));
  strokes &= ~wide;
}

}  // namespace

void EraseDashedLines(Ink& ink) {
  const double diagonal = std::hypot(ink.strokes.cols, ink.strokes.rows);
  constexpr double kLongest = 0.12, kWidestGap = 0.03;  // of the diagonal
  cv::Mat labels;
  const int count = cv::connectedComponents(ink.strokes, labels, 8, CV_32S);
  const std::vector<Dash> dashes = DashesAmong(labels, count, kLongest * diagonal);
  const std::vector<Dash> dashed = InDashedLines(dashes, DashLinks(dashes, kWidestGap * diagonal).Find());
  if (dashed.empty()) return;
  std::vector<char> is_dashed(count, 0);
  for (const Dash& dash : dashed) is_dashed[dash.label] = 1;
  ForEachLabelled(labels, [&](int label, const Vector2d& p) {
    if (is_dashed[label] != 0) ink.strokes.at<uchar>(static_cast<int>(p.y()), static_cast<int>(p.x())) = 0;
  });
  ErasePenOf(dashed, ink.strokes);
}

}  // namespace enfilade::perception

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>

#include "fmt/format.h"
#include "tests/bench/fleet/resource_samples.h"

namespace enfilade::bench {
namespace {

constexpr double kWidth = 720.0;
constexpr double kPanel = 130.0;  // height
constexpr double kLeft = 80.0;
constexpr double kRight = 20.0;
constexpr double kAbove = 34.0;  // of a panel's axes: its title
constexpr double kBelow = 16.0;

struct Panel {
  std::string title;
  std::function<double(const ResourceSample&)> value;
};

// Of the last minute, in cores.
std::vector<double> Rate(const std::vector<ResourceSample>& samples, double ResourceSample::*total) {
  std::vector<double> rates;
  for (std::size_t i = 0, first = 0; i < samples.size(); ++i) {
    while (samples[i].at - samples[first].at > 60.0) ++first;
    const double seconds = samples[i].at - samples[first].at;
    rates.push_back(seconds > 0.0 ? (samples[i].*total - samples[first].*total) / seconds : 0.0);
  }
  return rates;
}

std::string DrawPanel(const std::string& title, const std::vector<ResourceSample>& samples,
                      const std::vector<double>& values, double top) {
  const double end = std::max(1.0, samples.back().at);
  const double largest = std::max(1e-9, *std::max_element(values.begin(), values.end()));
  const double bottom = top + kPanel - kBelow;
  const double height = kPanel - kAbove - kBelow;
  std::string points;
  for (std::size_t i = 0; i < values.size(); ++i) {
    points += fmt::format("{:.1f},{:.1f} ", kLeft + samples[i].at / end * (kWidth - kLeft - kRight),
                          bottom - values[i] / largest * height);
  }
  return fmt::format(
      "<text x=\"{0}\" y=\"{1:.1f}\" font-weight=\"bold\">{2}</text>\n"
      "<text x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.4g}</text>\n"
      "<text x=\"{3:.1f}\" y=\"{6:.1f}\" text-anchor=\"end\">0</text>\n"
      "<path d=\"M{0} {4:.1f}V{6:.1f}H{7}\" fill=\"none\" stroke=\"#999\"/>\n"
      "<polyline points=\"{8}\" fill=\"none\" stroke=\"#1f5fa8\" stroke-width=\"1.5\"/>\n",
      kLeft, top + kAbove - 12.0, title, kLeft - 6.0, bottom - height, largest, bottom, kWidth - kRight, points);
}

}  // namespace

std::string DrawSamples(const std::vector<ResourceSample>& samples) {
  if (samples.empty()) return "";
  constexpr double kMiB = 1 << 20;
  const std::vector<Panel> panels = {
      {"Server's memory, MiB", [](const ResourceSample& s) { return static_cast<double>(s.server_bytes) / kMiB; }},
      {"Server's open files", [](const ResourceSample& s) { return s.server_files; }},
      {"Connections to the database", [](const ResourceSample& s) { return s.connections; }},
      {"Database, MiB", [](const ResourceSample& s) { return static_cast<double>(s.database_bytes) / kMiB; }},
      {"Records not yet mapped", [](const ResourceSample& s) { return static_cast<double>(s.backlog_records); }},
  };
  std::string body;
  double top = 0.0;
  const auto add = [&](const std::string& title, const std::vector<double>& values) {
    body += DrawPanel(title, samples, values, top);
    top += kPanel;
  };
  for (const Panel& panel : panels) {
    std::vector<double> values;
    for (const ResourceSample& sample : samples) values.push_back(panel.value(sample));
    add(panel.title, values);
  }
  add("Server, cores in use", Rate(samples, &ResourceSample::server_cpu_s));
  add("Database, cores in use", Rate(samples, &ResourceSample::database_cpu_s));
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\""
      " font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{2}"
      "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.0f} s</text>\n</svg>\n",
      kWidth, top + 20.0, body, kWidth - kRight, top + 8.0, samples.back().at);
}

}  // namespace enfilade::bench

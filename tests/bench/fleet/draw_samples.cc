// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

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

constexpr double kMiB = 1 << 20;
constexpr std::size_t kDrawnTables = 5;
constexpr const char* kColours[kDrawnTables] = {"#1f5fa8", "#c2571a", "#3a7d34", "#8a3b9c", "#7a6a1f"};

struct Series {
  std::string name;  // empty: the panel's only one
  std::vector<double> values;
};

struct Panel {
  std::string title;
  std::vector<Series> series;  // at most kDrawnTables
};

template <typename Value>
Panel PanelOf(const std::string& title, const std::vector<ResourceSample>& samples, const Value& value) {
  Panel panel{title, {{}}};
  for (const ResourceSample& sample : samples) panel.series[0].values.push_back(static_cast<double>(value(sample)));
  return panel;
}

// Of the largest tables.
Panel PanelOfTables(const std::string& title, const std::vector<ResourceSample>& samples,
                    std::int64_t TableSize::*bytes) {
  Panel panel{title, {}};
  for (const std::string& name : LargestTables(samples, kDrawnTables)) {
    Series series{name, {}};
    for (const ResourceSample& sample : samples) {
      const auto table = std::find_if(sample.tables.begin(), sample.tables.end(),
                                      [&](const TableSize& one) { return one.name == name; });
      series.values.push_back(table == sample.tables.end() ? 0.0 : static_cast<double>((*table).*bytes) / kMiB);
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

std::int64_t DeadRows(const ResourceSample& sample) {
  std::int64_t rows = 0;
  for (const TableSize& table : sample.tables) rows += table.dead_rows;
  return rows;
}

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

double LargestOf(const Panel& panel) {
  double largest = 1e-9;
  for (const Series& series : panel.series) {
    for (const double value : series.values) largest = std::max(largest, value);
  }
  return largest;
}

std::string DrawPanel(const Panel& panel, const std::vector<ResourceSample>& samples, double top) {
  const double end = std::max(1.0, samples.back().at);
  const double largest = LargestOf(panel);
  const double bottom = top + kPanel - kBelow;
  const double height = kPanel - kAbove - kBelow;
  std::string title = "<tspan font-weight=\"bold\">" + panel.title + "</tspan>";
  std::string lines;
  for (std::size_t k = 0; k < panel.series.size(); ++k) {
    std::string points;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      points += fmt::format("{:.1f},{:.1f} ", kLeft + samples[i].at / end * (kWidth - kLeft - kRight),
                            bottom - panel.series[k].values[i] / largest * height);
    }
    lines += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"/>\n", points,
                         kColours[k]);
    title += fmt::format("<tspan dx=\"8\" fill=\"{}\">{}</tspan>", kColours[k], panel.series[k].name);
  }
  return fmt::format(
      "<text x=\"{0}\" y=\"{1:.1f}\">{2}</text>\n"
      "<text x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.4g}</text>\n"
      "<text x=\"{3:.1f}\" y=\"{6:.1f}\" text-anchor=\"end\">0</text>\n"
      "<path d=\"M{0} {4:.1f}V{6:.1f}H{7}\" fill=\"none\" stroke=\"#999\"/>\n{8}",
      kLeft, top + kAbove - 12.0, title, kLeft - 6.0, bottom - height, largest, bottom, kWidth - kRight, lines);
}

std::vector<Panel> PanelsOf(const std::vector<ResourceSample>& samples) {
  return {
      PanelOf("Server's memory, MiB", samples,
              [](const ResourceSample& s) { return static_cast<double>(s.server_bytes) / kMiB; }),
      PanelOf("Server's open files", samples, [](const ResourceSample& s) { return s.server_files; }),
      PanelOf("Connections to the database", samples, [](const ResourceSample& s) { return s.connections; }),
      PanelOf("Database, MiB", samples,
              [](const ResourceSample& s) { return static_cast<double>(s.database_bytes) / kMiB; }),
      PanelOfTables("Tables, MiB", samples, &TableSize::bytes),
      PanelOfTables("Their indexes, MiB", samples, &TableSize::index_bytes),
      PanelOf("Dead rows", samples, DeadRows),
      PanelOf("Records not yet mapped", samples, [](const ResourceSample& s) { return s.backlog_records; }),
      {"Server, cores in use", {{"", Rate(samples, &ResourceSample::server_cpu_s)}}},
      {"Database, cores in use", {{"", Rate(samples, &ResourceSample::database_cpu_s)}}},
  };
}

}  // namespace

std::string DrawSamples(const std::vector<ResourceSample>& samples) {
  if (samples.empty()) return "";
  std::string body;
  double top = 0.0;
  for (const Panel& panel : PanelsOf(samples)) {
    body += DrawPanel(panel, samples, top);
    top += kPanel;
  }
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\""
      " font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{2}"
      "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.0f} s</text>\n</svg>\n",
      kWidth, top + 20.0, body, kWidth - kRight, top + 8.0, samples.back().at);
}

}  // namespace enfilade::bench

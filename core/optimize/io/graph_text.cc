// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/io/graph_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/information.h"
#include "core/optimize/initialization/spanning_tree.h"

namespace enfilade::optimize {
namespace {

using Fields = std::vector<std::string_view>;

Fields Split(std::string_view line) {
  constexpr std::string_view kSpace = " \t\r\v\f";
  line = line.substr(0, line.find('#'));
  Fields fields;
  for (std::size_t begin = line.find_first_not_of(kSpace); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSpace, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSpace, end);
  }
  return fields;
}

template <typename Number>
std::optional<Number> ToNumber(std::string_view field) {
  if (field.starts_with('+')) field.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size()) return std::nullopt;
  return value;
}

absl::StatusOr<std::int64_t> ToId(std::string_view field) {
  const std::optional<std::int64_t> id = ToNumber<std::int64_t>(field);
  if (!id) return InvalidArgument("'{}' is not a node id (an integer)", field);
  return *id;
}

// The fields from `first` on, as finite numbers.
absl::StatusOr<std::vector<double>> ToDoubles(const Fields& fields, std::size_t first) {
  std::vector<double> values;
  for (std::size_t i = first; i < fields.size(); ++i) {
    const std::optional<double> value = ToNumber<double>(fields[i]);
    if (!value || !std::isfinite(*value)) return InvalidArgument("'{}' is not a finite number", fields[i]);
    values.push_back(*value);
  }
  return values;
}

absl::Status ExpectFields(const Fields& fields, std::size_t count) {
  if (fields.size() == count) return absl::OkStatus();
  return InvalidArgument("{} has {} fields, not {}", fields[0], fields.size() - 1, count - 1);
}

bool IsThreeDimensional(std::string_view tag) {
  return tag == "VERTEX3" || tag == "EDGE3" || tag.starts_with("VERTEX_SE3") || tag.starts_with("EDGE_SE3");
}

class Parser {
 public:
  absl::Status ParseLine(const Fields& fields, int line) {
    const std::string_view tag = fields[0];
    if (IsThreeDimensional(tag)) {
      return InvalidArgument("{} belongs to a 3D graph; only 2D graphs (VERTEX_SE2, EDGE_SE2) are supported", tag);
    }
    if (tag == "VERTEX_SE2") return ParseVertex(fields, GraphFormat::kG2o);
    if (tag == "VERTEX2") return ParseVertex(fields, GraphFormat::kToro);
    if (tag == "EDGE_SE2") return ParseEdge(fields, GraphFormat::kG2o, line);
    if (tag == "EDGE2") return ParseEdge(fields, GraphFormat::kToro, line);
    if (tag == "FIX") return ParseFix(fields, line);
    if (skipped_line_ == 0) skipped_line_ = line;
    ++parsed_.skipped[std::string(tag)];
    return absl::OkStatus();
  }

  // On error, sets `line` to the line at fault.
  absl::StatusOr<ParsedPoseGraph> Finish(int& line) {
    if (!has_known_tag_ && !parsed_.skipped.empty()) {
      line = skipped_line_;
      return InvalidArgument("unknown tag {}, and no line with a known one: not a 2D pose graph in g2o or TORO format",
                             parsed_.skipped.begin()->first);
    }
    if (declared_.empty()) DeclareNodesOfEdges();
    for (std::size_t k = 0; k < edge_lines_.size(); ++k) {
      line = edge_lines_[k];
      for (const std::int64_t id : {parsed_.graph.edges[k].from, parsed_.graph.edges[k].to}) {
        if (!declared_.contains(id)) return InvalidArgument("the edge names node {}, which is not declared", id);
      }
    }
    for (std::size_t k = 0; k < fix_lines_.size(); ++k) {
      line = fix_lines_[k];
      if (!declared_.contains(parsed_.fixed[k])) {
        return InvalidArgument("FIX names node {}, which is not declared", parsed_.fixed[k]);
      }
    }
    if (parsed_.poses_from_edges) ENFILADE_RETURN_IF_ERROR(PoseNodesAlongEdges());
    return std::move(parsed_);
  }

 private:
  void NoteFormat(GraphFormat format) {
    if (!has_known_tag_) parsed_.format = format;
    has_known_tag_ = true;
  }

  absl::Status ParseVertex(const Fields& fields, GraphFormat format) {
    NoteFormat(format);
    ENFILADE_RETURN_IF_ERROR(ExpectFields(fields, 5));
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t id, ToId(fields[1]));
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<double> pose, ToDoubles(fields, 2));
    if (!declared_.insert(id).second) return InvalidArgument("node {} is declared a second time", id);
    parsed_.graph.nodes.push_back({id, {pose[0], pose[1], pose[2]}});
    return absl::OkStatus();
  }

  absl::Status ParseEdge(const Fields& fields, GraphFormat format, int line) {
    NoteFormat(format);
    ENFILADE_RETURN_IF_ERROR(ExpectFields(fields, 12));
    PoseGraphEdge edge;
    ENFILADE_ASSIGN_OR_RETURN(edge.from, ToId(fields[1]));
    ENFILADE_ASSIGN_OR_RETURN(edge.to, ToId(fields[2]));
    if (edge.from == edge.to) return InvalidArgument("the edge joins node {} to itself", edge.from);
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<double> v, ToDoubles(fields, 3));
    edge.T_from_to = {v[0], v[1], v[2]};
    if (format == GraphFormat::kG2o) {
      edge.information << v[3], v[4], v[5], v[4], v[6], v[7], v[5], v[7], v[8];
    } else {
      edge.information << v[3], v[4], v[7], v[4], v[5], v[8], v[7], v[8], v[6];
    }
    if (const absl::Status status = CheckInformation(edge.information); !status.ok()) {
      return WithContext(status, fmt::format("the edge {} -> {}", edge.from, edge.to));
    }
    parsed_.graph.edges.push_back(edge);
    edge_lines_.push_back(line);
    return absl::OkStatus();
  }

  absl::Status ParseFix(const Fields& fields, int line) {
    NoteFormat(GraphFormat::kG2o);
    if (fields.size() < 2) return InvalidArgument("FIX without a node id");
    for (std::size_t i = 1; i < fields.size(); ++i) {
      ENFILADE_ASSIGN_OR_RETURN(const std::int64_t id, ToId(fields[i]));
      parsed_.fixed.push_back(id);
      fix_lines_.push_back(line);
    }
    return absl::OkStatus();
  }

  void DeclareNodesOfEdges() {
    for (const PoseGraphEdge& edge : parsed_.graph.edges) {
      for (const std::int64_t id : {edge.from, edge.to}) {
        if (declared_.insert(id).second) parsed_.graph.nodes.push_back({id, {}});
      }
    }
    std::sort(parsed_.graph.nodes.begin(), parsed_.graph.nodes.end(),
              [](const PoseGraphNode& a, const PoseGraphNode& b) { return a.id < b.id; });
    parsed_.poses_from_edges = !declared_.empty();
  }

  absl::Status PoseNodesAlongEdges() {
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<IndexedGraph> components,
                              IndexComponents(parsed_.graph, parsed_.fixed));
    for (const IndexedGraph& component : components) {
      const std::vector<Pose2> poses = SpanningTreePoses(component);
      for (std::size_t i = 0; i < poses.size(); ++i) parsed_.graph.nodes[component.sources[i]].T_world_node = poses[i];
    }
    return absl::OkStatus();
  }

  ParsedPoseGraph parsed_;
  std::unordered_set<std::int64_t> declared_;
  std::vector<int> edge_lines_;  // one per edge
  std::vector<int> fix_lines_;   // one per fixed id
  bool has_known_tag_ = false;
  int skipped_line_ = 0;  // the first
};

void AppendEdge(const PoseGraphEdge& edge, GraphFormat format, std::string& text) {
  const Eigen::Matrix3d& I = edge.information;
  const Pose2& T = edge.T_from_to;
  const bool g2o = format == GraphFormat::kG2o;
  fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {} {} {} {} {} {}\n", g2o ? "EDGE_SE2" : "EDGE2",
                 edge.from, edge.to, T.x, T.y, T.yaw, I(0, 0), I(0, 1), g2o ? I(0, 2) : I(1, 1),
                 g2o ? I(1, 1) : I(2, 2), g2o ? I(1, 2) : I(0, 2), g2o ? I(2, 2) : I(1, 2));
}

}  // namespace

absl::StatusOr<ParsedPoseGraph> ParsePoseGraph(std::string_view text, const std::string& name) {
  Parser parser;
  int line = 0;
  while (!text.empty()) {
    ++line;
    const std::size_t end = std::min(text.find('\n'), text.size());
    const Fields fields = Split(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (fields.empty()) continue;
    if (const absl::Status status = parser.ParseLine(fields, line); !status.ok()) {
      return WithContext(status, fmt::format("{}:{}", name, line));
    }
  }
  absl::StatusOr<ParsedPoseGraph> parsed = parser.Finish(line);
  if (!parsed.ok()) return WithContext(parsed.status(), fmt::format("{}:{}", name, line));
  return parsed;
}

std::string WritePoseGraph(const PoseGraph& graph, GraphFormat format, const std::vector<std::int64_t>& fixed) {
  std::string text;
  const char* vertex = format == GraphFormat::kG2o ? "VERTEX_SE2" : "VERTEX2";
  for (const PoseGraphNode& node : graph.nodes) {
    const Pose2& T = node.T_world_node;
    fmt::format_to(std::back_inserter(text), "{} {} {} {} {}\n", vertex, node.id, T.x, T.y, T.yaw);
  }
  if (format == GraphFormat::kG2o) {
    for (const std::int64_t id : fixed) fmt::format_to(std::back_inserter(text), "FIX {}\n", id);
  }
  for (const PoseGraphEdge& edge : graph.edges) {
    if (edge.enabled) AppendEdge(edge, format, text);
  }
  return text;
}

}  // namespace enfilade::optimize

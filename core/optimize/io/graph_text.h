// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/optimize/pose_graph.h"

namespace enfilade::optimize {

// The two text formats of 2D pose graphs, one element per line:
//   g2o   VERTEX_SE2 id x y yaw | EDGE_SE2 i j x y yaw I11 I12 I13 I22 I23 I33 | FIX id...
//   TORO  VERTEX2 id x y yaw    | EDGE2 i j x y yaw I11 I12 I22 I33 I13 I23
enum class GraphFormat { kG2o, kToro };

struct ParsedPoseGraph {
  PoseGraph graph;                         // nodes and edges in the order of their lines
  GraphFormat format = GraphFormat::kG2o;  // of the first line with a known tag
  std::vector<std::int64_t> fixed;         // from FIX lines
  std::map<std::string, int> skipped;      // unknown tags, each with its number of lines
  // The text has edges but declares no node: the nodes are those of the edges, by id, posed along a spanning tree.
  bool poses_from_edges = false;
};

// Reads both formats, also mixed in one text. Blank lines and comments ('#' to the end of the line) are skipped.
// INVALID_ARGUMENT, with `name` and the line, for: a wrong number of fields, a field that is not a finite number, a
// node declared twice, an edge or FIX naming an undeclared node, an edge from a node to itself, information that is not
// positive definite, elements of 3D graphs, and a text with unknown tags only.
absl::StatusOr<ParsedPoseGraph> ParsePoseGraph(std::string_view text, const std::string& name);

// Every number reads back as the same double. Disabled edges are left out: the formats cannot express them. `fixed`
// is ignored for TORO, which has no FIX lines.
std::string WritePoseGraph(const PoseGraph& graph, GraphFormat format, const std::vector<std::int64_t>& fixed = {});

}  // namespace enfilade::optimize

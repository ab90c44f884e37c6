// SPDX-License-Identifier: Apache-2.0
// Pose graphs as text: g2o and TORO.
#include "core/optimize/io/graph_text.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  return {"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 7 1 0 0.1\nEDGE_SE2 0 7 1 0 0.1 100 0 0 100 0 400\nFIX 0\n# done\n",
          "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 50 1 50 10 0 0\n",
          "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n"};
}

bool Decode(std::string_view bytes) {
  const auto parsed = optimize::ParsePoseGraph(bytes, "fuzz");
  if (!parsed.ok()) return false;
  const std::string text = optimize::WritePoseGraph(parsed->graph, optimize::GraphFormat::kG2o, parsed->fixed);
  const auto same = optimize::ParsePoseGraph(text, "fuzz");
  Expect(same.ok() || parsed->graph.nodes.empty(), "a pose graph is read back");
  if (same.ok()) Expect(same->graph.nodes.size() == parsed->graph.nodes.size(), "with all its nodes");
  return true;
}

}  // namespace enfilade::fuzz

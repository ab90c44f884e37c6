// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/skeleton_chains.h"

#include <algorithm>
#include <array>

namespace enfilade::perception {
namespace {

class Follower {
 public:
  explicit Follower(const SkeletonView& skeleton)
      : skeleton_(skeleton),
        node_(static_cast<std::size_t>(skeleton.width) * skeleton.height, kNone),
        visited_(node_.size(), false) {}

  ChainGraph Follow() {
    const int count = skeleton_.width * skeleton_.height;
    for (int i = 0; i < count; ++i) {
      if (IsSet(i) && node_[i] == kNone && NeighboursOf(i).size() != 2) AddNode(i);
    }
    for (int i = 0; i < count; ++i) {
      if (node_[i] == kNone) continue;
      for (const int next : NeighboursOf(i)) {
        if (node_[next] == kNone && !visited_[next]) FollowFrom(i, next);
        if (node_[next] != kNone && node_[next] != node_[i] && i < next) AddChain(i, next, {});
      }
    }
    for (int i = 0; i < count; ++i) {  // circles without a node
      if (!IsSet(i) || node_[i] != kNone || visited_[i]) continue;
      AddNode(i);
      FollowFrom(i, NeighboursOf(i).front());
    }
    return std::move(graph_);
  }

 private:
  static constexpr int kNone = -1;

  bool IsSet(int i) const { return skeleton_.pixels[i] != 0; }
  Eigen::Vector2d PointOf(int i) const {
    return {static_cast<double>(i % skeleton_.width), static_cast<double>(i / skeleton_.width)};
  }

  std::vector<int> NeighboursOf(int i) const {
    std::vector<int> found;
    const int x = i % skeleton_.width, y = i / skeleton_.width;
    for (int v = std::max(0, y - 1); v <= std::min(skeleton_.height - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(skeleton_.width - 1, x + 1); ++u) {
        const int j = v * skeleton_.width + u;
        if (j != i && IsSet(j)) found.push_back(j);
      }
    }
    return found;
  }

  // Pixels of branchings that touch each other are one node.
  void AddNode(int first) {
    const int number = static_cast<int>(graph_.nodes.size());
    std::vector<int> members{first};
    node_[first] = number;
    const bool branching = NeighboursOf(first).size() > 2;
    for (std::size_t k = 0; branching && k < members.size(); ++k) {
      for (const int next : NeighboursOf(members[k])) {
        if (node_[next] != kNone || NeighboursOf(next).size() <= 2) continue;
        node_[next] = number;
        members.push_back(next);
      }
    }
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double half_width = 0;
    for (const int i : members) {
      sum += PointOf(i);
      half_width = std::max<double>(half_width, skeleton_.half_width[i]);
    }
    graph_.nodes.push_back(sum / static_cast<double>(members.size()));
    graph_.node_half_width.push_back(half_width);
  }

  void FollowFrom(int node, int first) {
    std::vector<int> pixels;
    int last = node, here = first;
    while (node_[here] == kNone) {
      visited_[here] = true;
      pixels.push_back(here);
      int next = kNone;
      for (const int j : NeighboursOf(here)) {
        if (j != last && !(node_[j] == kNone && visited_[j])) next = j;
      }
      if (next == kNone) next = node;  // a circle of two pixels
      last = here;
      here = next;
    }
    AddChain(node, here, std::move(pixels));
  }

  void AddChain(int from, int to, std::vector<int> pixels) {
    graph_.chains.push_back({.from = node_[from], .to = node_[to], .pixels = std::move(pixels)});
  }

  const SkeletonView& skeleton_;
  std::vector<int> node_;
  std::vector<bool> visited_;
  ChainGraph graph_;
};

std::vector<std::vector<int>> ChainsAtNodes(const ChainGraph& graph) {
  std::vector<std::vector<int>> at(graph.nodes.size());
  for (std::size_t i = 0; i < graph.chains.size(); ++i) {
    if (graph.chains[i].dropped) continue;
    at[graph.chains[i].from].push_back(static_cast<int>(i));
    at[graph.chains[i].to].push_back(static_cast<int>(i));
  }
  return at;
}

// Thinning leaves stubs from the middle of a stroke into its corners: as long as half its width, times sqrt(2).
bool DropStubs(ChainGraph& graph) {
  const auto at = ChainsAtNodes(graph);
  bool any = false;
  for (Chain& chain : graph.chains) {
    if (chain.dropped || chain.from == chain.to) continue;
    const bool from_ends = at[chain.from].size() == 1, to_ends = at[chain.to].size() == 1;
    if (from_ends == to_ends) continue;
    const double half_width = graph.node_half_width[from_ends ? chain.to : chain.from];
    if (static_cast<double>(chain.pixels.size()) > 1.3 * half_width + 1) continue;
    chain.dropped = true;
    any = true;
  }
  return any;
}

// Two chains that meet at a node of no others become one.
void JoinChains(ChainGraph& graph) {
  auto at = ChainsAtNodes(graph);
  for (std::size_t node = 0; node < at.size(); ++node) {
    if (at[node].size() != 2 || at[node][0] == at[node][1]) continue;
    Chain& first = graph.chains[at[node][0]];
    Chain& second = graph.chains[at[node][1]];
    const int here = static_cast<int>(node);
    if (first.to != here) {
      std::reverse(first.pixels.begin(), first.pixels.end());
      std::swap(first.from, first.to);
    }
    if (second.from != here) {
      std::reverse(second.pixels.begin(), second.pixels.end());
      std::swap(second.from, second.to);
    }
    first.pixels.insert(first.pixels.end(), second.pixels.begin(), second.pixels.end());
    first.to = second.to;
    second.dropped = true;
    for (int& chain : at[second.to]) {
      if (chain == at[node][1]) chain = at[node][0];
    }
  }
}

}  // namespace

ChainGraph FollowSkeleton(const SkeletonView& skeleton) {
  ChainGraph graph = Follower(skeleton).Follow();
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    if (!DropStubs(graph)) break;
    JoinChains(graph);
  }
  JoinChains(graph);
  std::erase_if(graph.chains, [](const Chain& chain) { return chain.dropped; });
  return graph;
}

}  // namespace enfilade::perception

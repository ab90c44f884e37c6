// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/mapper_state.h"

#include <algorithm>
#include <utility>

namespace enfilade::slam {
namespace {

constexpr std::size_t kMapNodeBytes = 48;  // overhead of a std::map or std::set per element

}  // namespace

bool IsRecognised(const MapperState& state, std::int64_t since) {
  return std::any_of(state.loop_closures.begin(), state.loop_closures.end(), [&](const auto& entry) {
    const LoopClosure& closure = entry.second;
    if (closure.state != LoopClosureState::kAccepted) return false;
    return (closure.submap < since) != (state.nodes.at(closure.node).submap < since);
  });
}

void Join(const LoopClosure& closure, MapperState& state) {
  if (closure.state != LoopClosureState::kAccepted) return;
  const std::int64_t other = state.nodes.at(closure.node).submap;
  state.joined[closure.submap].insert(other);
  state.joined[other].insert(closure.submap);
}

void JoinAll(MapperState& state) {
  state.joined.clear();
  for (const auto& [id, closure] : state.loop_closures) Join(closure, state);
}

std::size_t KeptBytes(const MapperState& state) {
  std::size_t bytes = state.nodes.size() * (sizeof(std::pair<const std::int64_t, SlamNode>) + kMapNodeBytes);
  for (const auto& [id, submap] : state.finished) {
    bytes += sizeof(std::pair<const std::int64_t, FinishedSubmap>) + kMapNodeBytes + submap.content.capacity() +
             submap.nodes.capacity() * sizeof(SubmapNode);
  }
  for (const auto& [id, closure] : state.loop_closures) {
    bytes += sizeof(std::pair<const std::int64_t, LoopClosure>) + kMapNodeBytes + closure.reason.capacity();
  }
  for (const auto& [id, others] : state.joined) bytes += (1 + others.size()) * (sizeof(id) + kMapNodeBytes);
  return bytes;
}

}  // namespace enfilade::slam

// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/region_graph.h"

#include <map>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

namespace enfilade::rooms {
namespace {

class Contraction {
 public:
  Contraction(int regions, std::span<const RegionBorder> borders)
      : parent_(static_cast<std::size_t>(regions)), around_(static_cast<std::size_t>(regions)) {
    std::iota(parent_.begin(), parent_.end(), 0);
    for (const RegionBorder& border : borders) {
      if (border.one == border.other) continue;
      Around(border.one)[border.other] += border.weight;
      Around(border.other)[border.one] += border.weight;
    }
    for (int region = 0; region < regions; ++region) {
      for (const auto& [other, weight] : Around(region)) {
        if (region < other) Offer(region, other, weight);
      }
    }
  }

  void Run() {
    while (!offers_.empty()) {
      const auto [weight, minus_one, minus_other] = offers_.top();
      offers_.pop();
      const int one = -minus_one;
      const int other = -minus_other;
      if (Root(one) != one || Root(other) != other) continue;
      const auto found = Around(one).find(other);
      if (found == Around(one).end() || found->second != weight) continue;  // an outdated offer
      Join(one, other);
    }
  }

  int Root(int region) const {
    while (parent_[static_cast<std::size_t>(region)] != region) region = parent_[static_cast<std::size_t>(region)];
    return region;
  }

 private:
  std::map<int, double>& Around(int region) { return around_[static_cast<std::size_t>(region)]; }

  void Offer(int one, int other, double weight) {
    if (weight > 0.0) offers_.emplace(weight, -std::min(one, other), -std::max(one, other));
  }

  void Join(int kept, int gone) {
    if (Around(kept).size() < Around(gone).size()) std::swap(kept, gone);
    parent_[static_cast<std::size_t>(gone)] = kept;
    Around(kept).erase(gone);
    const std::map<int, double> moved = std::move(Around(gone));
    Around(gone).clear();
    for (const auto& [other, weight] : moved) {
      if (other == kept) continue;
      Around(other).erase(gone);
      const double sum = Around(kept)[other] += weight;
      Around(other)[kept] = sum;
      Offer(kept, other, sum);
    }
  }

  std::vector<int> parent_;
  std::vector<std::map<int, double>> around_;
  std::priority_queue<std::tuple<double, int, int>> offers_;  // equal weights: the lower regions first
};

}  // namespace

std::vector<int> ClusterRegions(int regions, std::span<const RegionBorder> borders) {
  Contraction contraction(regions, borders);
  contraction.Run();
  std::vector<int> number(static_cast<std::size_t>(regions), -1);
  std::vector<int> rooms;
  int count = 0;
  for (int region = 0; region < regions; ++region) {
    int& room = number[static_cast<std::size_t>(contraction.Root(region))];
    if (room < 0) room = count++;
    rooms.push_back(room);
  }
  return rooms;
}

}  // namespace enfilade::rooms

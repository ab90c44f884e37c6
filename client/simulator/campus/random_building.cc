// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/random_building.h"

#include "client/simulator/campus/building_draft.h"
#include "fmt/format.h"

namespace enfilade::simulator {

BuildingDraft::BuildingDraft(std::uint64_t seed, const BuildingOptions& building_options)
    : options(building_options), noise(Mix(seed, 0xB01D)) {
  campus.name = fmt::format("random-{}", seed);
  campus.texture_seed = seed;
  campus.levels["ground"] = 0.0;
  campus.textures["plain"] = Texture{};
  campus.wall_thickness = noise.Uniform(0.1, 0.3);
}

Campus RandomBuilding(std::uint64_t seed, const BuildingOptions& options) {
  BuildingDraft draft(seed, options);
  LayOutSpaces(draft);
  PlanRoute(draft);
  Furnish(draft);
  AddSecondRobot(draft, seed);
  return std::move(draft.campus);
}

}  // namespace enfilade::simulator

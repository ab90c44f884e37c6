// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/localizer_options.h"

namespace enfilade::prior {

std::string_view NameOf(PlanSight sight) { return sight == PlanSight::kNdt ? "ndt" : "field"; }

std::optional<PlanSight> PlanSightFrom(std::string_view name) {
  for (const PlanSight sight : {PlanSight::kField, PlanSight::kNdt}) {
    if (NameOf(sight) == name) return sight;
  }
  return std::nullopt;
}

PlanLocalizerOptions WithNav2Measurement(PlanLocalizerOptions options) {
  options.sight = PlanSight::kField;
  options.free_scale = false;
  options.sum = BeamSum::kCubes;
  options.beams = 60;
  options.max_range = 100;
  options.z_hit = 0.5;
  options.z_rand = 0.5 / 100;
  options.sigma_hit = 0.2;
  options.sigma_plan = 0;
  options.stretch_per_metre = 0;
  options.most_particles = 2000;
  options.alpha_slow = 0;
  options.alpha_fast = 0;
  options.compare_rivals = false;
  return options;
}

}  // namespace enfilade::prior

// SPDX-License-Identifier: Apache-2.0
#include "core/closure/door_knowledge.h"

namespace enfilade::closure {

ComparedPlace& PlaceAt(DoorKnowledge& knowledge, const PlaceIndex& index) {
  return index.passed ? knowledge.passed->link_points[index.index].place : (*knowledge.places)[index.index];
}

}  // namespace enfilade::closure

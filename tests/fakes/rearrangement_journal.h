// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>

#include "storage/graph/rearrangement_store.h"
#include "tests/fakes/in_memory_tables.h"

namespace enfilade::testing {

// What InMemoryRearrangementStore keeps of what it changes, so that undoing can tell later changes and restore the
// rest.

// (relation, key): storage::image
using Images = std::map<std::pair<std::string, std::string>, std::string>;

// Keeps the rows that the row's rearrangement will change, and their images.
void KeepBefore(const SiteRows& site, RearrangementRow& row);
// The images of what was kept, as it is now. Those of places are left out: they change by themselves.
Images PresentImages(const SiteRows& site, const RearrangementRow& row);

}  // namespace enfilade::testing

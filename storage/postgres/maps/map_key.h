// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/ids.h"

namespace enfilade::storage::postgres {

struct MapKey {
  SiteId site;
  MapId map;
};

}  // namespace enfilade::storage::postgres

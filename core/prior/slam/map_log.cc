// SPDX-License-Identifier: Apache-2.0
#include "core/prior/slam/map_log.h"

#include "core/slam/mapper/mapper.h"

namespace enfilade::prior {

MappedLog MapLog(const std::vector<sensor::PairedScan>& scans, const slam::SlamOptions& options) {
  slam::Mapper mapper(options);
  for (const sensor::PairedScan& scan : scans) mapper.AddScan(scan);
  mapper.Finish();
  MappedLog mapped;
  mapped.grid = mapper.RenderGrid();
  mapped.map.Apply(mapper.TakeDelta());
  return mapped;
}

}  // namespace enfilade::prior

// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "client/sources/log_reader.h"
#include "core/slam/mapper/log_mapper.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::slam {
namespace {

std::vector<sensor::Record> ReadLog(const std::filesystem::path& path, std::size_t limit) {
  std::vector<sensor::Record> records;
  auto reader = sources::LogReader::Open(path);
  EXPECT_OK(reader.status());
  while (reader.ok() && records.size() < limit) {
    auto entry = reader->Next();
    EXPECT_OK(entry.status());
    if (!entry.ok() || !*entry) break;
    records.push_back({static_cast<std::int64_t>(records.size()) + 1, std::move((*entry)->payload)});
  }
  return records;
}

struct Mapped {
  SlamMap map;
  grid::OccupancyGrid grid;
};

// Restores the mapper from a checkpoint after every `every` records.
Mapped MapRecords(const std::vector<sensor::Record>& records, std::size_t every) {
  LogMapper mapper({}, {});
  Mapped mapped;
  for (std::size_t i = 0; i < records.size(); ++i) {
    mapper.Add(records[i]);
    if (i % every != every - 1) continue;
    mapped.map.Apply(mapper.TakeDelta());
    auto restored = LogMapper::Restore({}, {}, mapped.map, mapper.Checkpoint());
    EXPECT_OK(restored.status());
    if (!restored.ok()) return mapped;
    mapper = *std::move(restored);
  }
  mapper.Finish();
  mapped.grid = mapper.RenderGrid();
  mapped.map.Apply(mapper.TakeDelta());
  return mapped;
}

TEST(MapperRecording, GivesTheSameMapWhereverItIsStoppedAndGoesOn) {
  ENFILADE_RECORDING_OR_SKIP(path, "laser/derived/intel_raw_odom.clf.gz");
  const std::vector<sensor::Record> records = ReadLog(path, 2400);
  const Mapped expected = MapRecords(records, records.size() + 1);
  EXPECT_GT(expected.map.loop_closures.size(), 10U);
  for (const std::size_t every : {97UL, 701UL}) {
    const Mapped actual = MapRecords(records, every);
    EXPECT_TRUE(actual.map.nodes == expected.map.nodes) << every;
    EXPECT_TRUE(actual.map.submaps == expected.map.submaps) << every;
    EXPECT_TRUE(actual.map.loop_closures == expected.map.loop_closures) << every;
    EXPECT_TRUE(actual.map.trajectory == expected.map.trajectory) << every;
    EXPECT_TRUE(actual.grid == expected.grid) << every;
  }
}

}  // namespace
}  // namespace enfilade::slam

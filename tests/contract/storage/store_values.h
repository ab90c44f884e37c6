// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/sensor/record.h"
#include "storage/graph/link_point_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/session_store.h"
#include "storage/sites/robot_store.h"
#include "storage/sites/site_store.h"

namespace enfilade::testing {

storage::Site MakeSite(const SiteId& id, const std::string& display_name);
storage::Robot MakeRobot(const SiteId& site, const RobotId& id, const std::string& display_name);
storage::Map MakeMap(const SiteId& site, const MapId& id, const std::string& display_name);
storage::Session MakeSession(const SiteId& site, const SessionId& id, const RobotId& robot,
                             const std::optional<MapId>& map);

// With the default covariance.
graph::Anchor MakeAnchor(const std::string& map, double x, double y, double yaw = 0.0);
storage::StoredLinkPoint MakeLinkPoint(const SiteId& site, const std::string& id,
                                       const std::vector<graph::Anchor>& anchors);

// The delta and the checkpoint must outlive the step.
storage::MappingStep StepOf(const slam::SlamDelta& delta, std::string_view checkpoint, std::int64_t mapped_sequence);

// A scan of `beams` beams at second `sequence`, with ranges that differ from any other sequence's.
sensor::Record ScanRecord(std::int64_t sequence, std::size_t beams = 4);
sensor::Record OdometryRecord(std::int64_t sequence);
sensor::Record ImageRecord(std::int64_t sequence, const sensor::BlobRef& content);
sensor::Record WithheldRecord(std::int64_t sequence);
std::vector<sensor::Record> ScanRecords(std::int64_t first, std::int64_t last);

// `data` with its digest. Holds both; view() refers to them.
class TestBlob {
 public:
  explicit TestBlob(std::string data);
  storage::BlobView view() const { return {sha256_, data_}; }
  sensor::BlobRef ref() const { return {sha256_, static_cast<std::int64_t>(data_.size())}; }
  const std::string& sha256() const { return sha256_; }
  const std::string& data() const { return data_; }

 private:
  std::string data_;
  std::string sha256_;
};

}  // namespace enfilade::testing

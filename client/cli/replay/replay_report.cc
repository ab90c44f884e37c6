// SPDX-License-Identifier: Apache-2.0
#include "client/cli/replay/replay_report.h"

#include <algorithm>
#include <string>

#include "client/cli/output.h"
#include "fmt/format.h"

namespace enfilade::cli {

nlohmann::json ReplayToJson(const ReplayOptions& options, const ReplayResult& result) {
  const sources::LogCounts& counts = result.log.counts;
  const std::int64_t sent = result.log.entries - result.resumed_after;
  nlohmann::json document = {{"log", options.log},
                             {"format", sources::ToString(result.log.facts.format)},
                             {"session", result.session.value()},
                             {"robot", options.robot},
                             {"map", options.map},
                             {"records", result.log.entries},
                             {"scans", counts.scans},
                             {"odometry", counts.odometry},
                             {"images", counts.images},
                             {"point_clouds", counts.point_clouds},
                             {"times", result.log.facts.times},
                             {"range_max_m", std::stod(fmt::format("{}", result.log.facts.range_max))},
                             {"bad_lines", counts.bad_lines},
                             {"skipped_lines", counts.skipped_lines},
                             {"scans_back_in_time", counts.scans_back_in_time},
                             {"odometry_back_in_time", counts.odometry_back_in_time},
                             {"beams_no_return", counts.beams_no_return},
                             {"beams_unknown", counts.beams_unknown},
                             {"acknowledged_sequence", result.uplink.acknowledged_sequence},
                             {"resumed_after", result.resumed_after},
                             {"quarantined", result.uplink.quarantined},
                             {"connections", result.uplink.connections},
                             {"seconds", result.seconds},
                             {"records_per_s", static_cast<double>(sent) / std::max(result.seconds, 1e-9)}};
  if (result.mapped) {
    const v1::MappingCounts& mapping = result.mapped->mapping_counts();
    document["mapped"] = {{"sequence", result.mapped->mapped_sequence()},
                          {"scans_used", mapping.used()},
                          {"keyframes", mapping.keyframes()},
                          {"lost", mapping.lost()},
                          {"unpaired", mapping.unpaired()},
                          {"seconds", result.mapping_s}};
  }
  return document;
}

void PrintLog(std::ostream& out, const ReplayOptions& options, const CheckedLog& log) {
  const sources::LogCounts& counts = log.counts;
  out << fmt::format("{}: {}, {} scans, {} odometry", options.log, sources::ToString(log.facts.format), counts.scans,
                     counts.odometry);
  if (counts.images > 0) out << fmt::format(", {} images", counts.images);
  if (counts.point_clouds > 0) out << fmt::format(", {} point clouds", counts.point_clouds);
  out << "; times: " << log.facts.times;
  if (log.facts.range_max > 0.0F) out << fmt::format("; no return from {} m", log.facts.range_max);
  out << '\n';
  for (const auto& [tag, lines] : counts.skipped_lines) out << fmt::format("  {} {} lines skipped\n", lines, tag);
  if (counts.bad_lines > 0) out << fmt::format("  {} bad lines skipped\n", counts.bad_lines);
  const std::int64_t back = counts.scans_back_in_time + counts.odometry_back_in_time;
  if (back > 0) out << fmt::format("  {} times go backwards\n", back);
}

void PrintReplay(std::ostream& out, const ReplayOptions& options, const ReplayResult& result) {
  const std::int64_t sent = result.log.entries - result.resumed_after;
  out << fmt::format("session {}: {} records ({} scans) acknowledged", result.session.value(), result.log.entries,
                     result.log.counts.scans);
  if (result.resumed_after > 0) out << fmt::format(", {} of them by an earlier run", result.resumed_after);
  out << fmt::format("; {} in {}, {:.0f}/s\n", sent, FormatSeconds(result.seconds),
                     static_cast<double>(sent) / std::max(result.seconds, 1e-9));
  if (result.uplink.quarantined > 0) {
    out << fmt::format("  the server refused {} records, which are kept in {}\n", result.uplink.quarantined,
                       result.spool_path);
  }
  if (!result.mapped) return;
  const v1::MappingCounts& mapping = result.mapped->mapping_counts();
  out << fmt::format("map {}: {} scans used, {} keyframes, {} lost, {} without odometry; {} after the last record\n",
                     options.record_only ? "-" : options.map, mapping.used(), mapping.keyframes(), mapping.lost(),
                     mapping.unpaired(), FormatSeconds(result.mapping_s));
}

}  // namespace enfilade::cli

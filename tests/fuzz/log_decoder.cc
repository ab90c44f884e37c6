// SPDX-License-Identifier: Apache-2.0
// Recorded logs, plain or compressed: of the format ENFILADE_FUZZED_LOG.
#include <fstream>
#include <iterator>

#include "client/sources/formats/json_lines_writer.h"
#include "client/sources/log_reader.h"
#include "tests/fuzz/decoder.h"
#include "tests/fuzz/memory_file.h"

namespace enfilade::fuzz {
namespace {

std::string ProjectLog(const std::string& name) {
  std::ifstream file(std::string(ENFILADE_SOURCE_DIR "/tests/data/logs/") + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

#if ENFILADE_FUZZED_LOG == 1
constexpr auto kFormat = sources::LogFormat::kCarmen;
std::vector<std::string> OwnLogs() { return {ProjectLog("small.clf")}; }
#elif ENFILADE_FUZZED_LOG == 2
constexpr auto kFormat = sources::LogFormat::kJsonLines;
std::vector<std::string> OwnLogs() {
  const std::string content = std::string("\"file\":\"") + ENFILADE_SOURCE_DIR "/tests/data/logs/small.clf\"}\n";
  return {ProjectLog("small.jsonl"), sources::JsonLinesHeader() +
                                         R"({"type":"image","time_ns":1,"camera":"front","encoding":"png",)" + content +
                                         R"({"type":"point_cloud","time_ns":2,"encoding":"pcd",)" + content};
}
#elif ENFILADE_FUZZED_LOG == 3
constexpr auto kFormat = sources::LogFormat::kWeanHall;
std::vector<std::string> OwnLogs() { return {ProjectLog("wean_hall.log")}; }
#else
constexpr auto kFormat = sources::LogFormat::kMinesParis;
std::vector<std::string> OwnLogs() { return {ProjectLog("mines_paris.dat")}; }
#endif

// False at the first line that is refused.
bool ReadWhole(const std::string& path, bool skip_bad_lines) {
  sources::LogOptions options;
  options.format = kFormat;
  options.skip_bad_lines = skip_bad_lines;
  auto reader = sources::LogReader::Open(path, options);
  if (!reader.ok()) return false;
  std::int64_t delivered = 0;
  auto entry = reader->Next();
  for (; entry.ok() && entry->has_value(); entry = reader->Next()) {
    Expect(sensor::Validate((*entry)->payload).ok(), "a log delivers valid records");
    Expect(sources::ToJsonLine(**entry).ok(), "what a log delivers can be written");
    ++delivered;
  }
  Expect(delivered <= reader->facts().entries, "a log delivers no more than announced");
  return entry.ok();
}

}  // namespace

std::vector<std::string> Seeds() { return OwnLogs(); }

bool Decode(std::string_view bytes) {
  const MemoryFile file(bytes);
  (void)ReadWhole(file.path(), true);
  return ReadWhole(file.path(), false);
}

}  // namespace enfilade::fuzz

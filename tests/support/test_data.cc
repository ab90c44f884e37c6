// SPDX-License-Identifier: Apache-2.0
#include "tests/support/test_data.h"

#include <cstdlib>
#include <stdexcept>
#include <system_error>

namespace enfilade::testing {
namespace {

namespace fs = std::filesystem;

fs::path SourceDir() { return ENFILADE_SOURCE_DIR; }

}  // namespace

std::optional<fs::path> FindRecording(const std::string& relative) {
  const char* data = std::getenv("ENFILADE_DATA");
  const fs::path path = (data ? fs::path(data) : SourceDir() / "../shared/data") / relative;
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return std::nullopt;
  return path;
}

fs::path ProjectData(const std::string& relative) { return SourceDir() / "tests/data" / relative; }

fs::path Program(const std::string& name) { return fs::read_symlink("/proc/self/exe").parent_path() / name; }

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (fs::temp_directory_path() / "enfilade-test-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("cannot make a temporary directory " + name);
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace enfilade::testing

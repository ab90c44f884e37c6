// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/processor_time.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace enfilade::bench {
namespace {

struct ProcessTimes {
  pid_t parent = 0;
  double own_s = 0.0;
  double ended_children_s = 0.0;
};

ProcessTimes TimesOf(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string stat;
  std::getline(file, stat, '\0');                // nothing if the process ends meanwhile
  const std::size_t name_end = stat.rfind(')');  // a name may have spaces
  if (name_end == std::string::npos) return {};
  std::istringstream fields(stat.substr(name_end + 2));
  const std::vector<std::string> values{std::istream_iterator<std::string>(fields), {}};
  if (values.size() < 15) return {};
  const auto seconds = [&](std::size_t user, std::size_t system) {
    return static_cast<double>(std::stoll(values[user]) + std::stoll(values[system])) /
           static_cast<double>(sysconf(_SC_CLK_TCK));
  };
  return {std::stoi(values[1]), seconds(11, 12), seconds(13, 14)};
}

}  // namespace

double ProcessorSeconds(pid_t pid) { return TimesOf(pid).own_s; }

double ProcessorSecondsOfTree(pid_t root) {
  const ProcessTimes times = TimesOf(root);
  double total = times.own_s + times.ended_children_s;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (!std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; })) continue;
    const ProcessTimes child = TimesOf(std::stoi(name));
    if (child.parent == root) total += child.own_s;
  }
  return total;
}

}  // namespace enfilade::bench

// SPDX-License-Identifier: Apache-2.0
// A fuzzer without libFuzzer: decodes the seeds, then `--runs` mutations of them, the same ones each time.
//   fuzz_X [--runs N] [--first I]   # input I, I + 1, ...: the message of a crash names I
//   fuzz_X --write-seeds FOLDER     # a corpus for libFuzzer
//   fuzz_X FILE...                  # decodes files, such as those that libFuzzer found
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "CLI/CLI.hpp"
#include "tests/fuzz/decoder.h"
#include "tests/fuzz/mutate.h"

namespace enfilade::fuzz {
namespace {

// Of a program that decodes 64 KiB; not under sanitizers, which reserve address space.
constexpr rlim_t kMaxMemoryBytes = rlim_t{3} << 30;

volatile sig_atomic_t current_input = 0;

void NameInput(int signal_number) {
  char message[64];
  const int size = std::snprintf(message, sizeof(message), "signal %d in input %d\n", signal_number,
                                 static_cast<int>(current_input));
  if (write(STDERR_FILENO, message, static_cast<std::size_t>(size)) < 0) _exit(1);
  signal(signal_number, SIG_DFL);
  raise(signal_number);
}

void WriteSeeds(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const std::string& seed : Seeds()) {
    std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary) << seed;
  }
}

void DecodeFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::printf("%s: %s\n", path.c_str(), Decode(bytes) ? "accepted" : "refused");
}

void DecodeMutations(int first, int runs) {
  const std::vector<std::string> seeds = Seeds();
  Expect(!seeds.empty(), "a decoder has seeds");
  for (const std::string& seed : seeds) Expect(Decode(seed), "a seed is accepted");
  int accepted = 0;
  for (int input = first; input < first + runs; ++input) {
    current_input = input;
    std::mt19937_64 random(static_cast<std::uint64_t>(input));
    accepted += Decode(Mutate(seeds, random)) ? 1 : 0;
  }
  std::printf("%zu seeds and %d mutations decoded, %d of them accepted\n", seeds.size(), runs, accepted);
}

}  // namespace
}  // namespace enfilade::fuzz

int main(int argc, char** argv) {
  CLI::App app("Decodes seeds and mutations of them");
  int runs = 3000;
  int first = 1;
  std::string folder;
  std::vector<std::string> files;
  app.add_option("--runs", runs, "mutations to decode");
  app.add_option("--first", first, "the number of the first one");
  app.add_option("--write-seeds", folder, "write the seeds to this folder instead");
  app.add_option("file", files, "decode these files instead");
  CLI11_PARSE(app, argc, argv);

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(ENFILADE_LIBFUZZER)
  const rlimit memory{enfilade::fuzz::kMaxMemoryBytes, enfilade::fuzz::kMaxMemoryBytes};
  setrlimit(RLIMIT_AS, &memory);
#endif
  for (const int number : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE}) signal(number, enfilade::fuzz::NameInput);

  if (!folder.empty()) {
    enfilade::fuzz::WriteSeeds(folder);
  } else if (!files.empty()) {
    for (const std::string& file : files) enfilade::fuzz::DecodeFile(file);
  } else {
    enfilade::fuzz::DecodeMutations(first, runs);
  }
}

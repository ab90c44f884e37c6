// SPDX-License-Identifier: Apache-2.0
// usage: campus_seeds [--campus NAME] [--seeds N] [--first SEED] [--robots r1,r2] [--verdicts yes]
// Automatic mapping of a simulated campus with many seeds of noise, each on its own site of a private server and
// database. Prints a table and a summary, with every verdict if requested. Exit code 1 if less than 95 % of the graphs
// are exact or a closure is false.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

#include "fmt/format.h"
#include "tests/e2e/campus_run.h"

namespace {

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  using namespace enfilade::testing;
  int seeds = 20;
  CampusRun run;
  bool with_verdicts = false;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--seeds") seeds = std::stoi(argv[i + 1]);
    if (option == "--first") run.seed = std::stoull(argv[i + 1]);
    if (option == "--campus") run.campus = argv[i + 1];
    if (option == "--verdicts") with_verdicts = std::string(argv[i + 1]) == "yes";
    if (option == "--robots") {
      run.robots.clear();
      std::stringstream names(argv[i + 1]);
      for (std::string name; std::getline(names, name, ',');) run.robots.push_back(name);
    }
  }
  constexpr double kDegrees = 180.0 / M_PI;
  std::cout << "seed  exact  false closures  error m  error deg  inside  seconds  graph" << std::endl;
  int exact = 0;
  int false_closures = 0;
  int samples = 0;
  int inside = 0;
  std::vector<double> errors;
  std::vector<double> yaw_errors;
  try {
    WholeSystem system(Cluster::Durability::kFast, {});
    for (int i = 0; i < seeds; ++i, ++run.seed) {
      const CampusResult result = RunCampus(system, run);
      std::cout << fmt::format("{:4}  {:5}  {:14}  {:7.3f}  {:9.2f}  {:2}/{:2}  {:7.1f}  {}", run.seed,
                               result.exact ? "yes" : "no", result.false_closures, result.final_error,
                               result.final_yaw_error * kDegrees, result.inside, result.samples, result.seconds,
                               result.graph)
                << std::endl;
      if (with_verdicts) {
        for (const std::string& verdict : result.verdicts) std::cout << "    " << verdict << std::endl;
      }
      exact += result.exact ? 1 : 0;
      false_closures += result.false_closures;
      samples += result.samples;
      inside += result.inside;
      errors.push_back(result.final_error);
      yaw_errors.push_back(result.final_yaw_error * kDegrees);
    }
  } catch (const std::exception& error) {
    std::cerr << "campus_seeds: " << error.what() << '\n';
    return 2;
  }
  std::cout << fmt::format(
      "{} of {} graphs exact, {} false closures; final pose error: median {:.3f} m, {:.2f} deg; truth inside the 95 % "
      "ellipse: {:.1f} % of {} samples\n",
      exact, seeds, false_closures, MedianOf(errors), MedianOf(yaw_errors), 100.0 * inside / std::max(samples, 1),
      samples);
  return exact * 20 >= seeds * 19 && false_closures == 0 ? 0 : 1;
}

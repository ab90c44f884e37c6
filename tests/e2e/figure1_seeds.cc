// usage: figure1_seeds [--seeds N] [--first SEED] [--robots r1,r2]
// Automatic mapping of the campus of figure 1 over many seeds of noise, each on a site of its own of a private server
// and database: a table, and what it comes to. Exit code 1 where less than 95 % of the graphs are exact or a closure is
// false.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

#include "fmt/format.h"
#include "tests/e2e/figure1_run.h"

namespace {

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  using namespace enfilade::testing;
  int seeds = 20;
  std::uint64_t first = 1;
  std::vector<std::string> robots = {"r1"};
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--seeds") seeds = std::stoi(argv[i + 1]);
    if (option == "--first") first = std::stoull(argv[i + 1]);
    if (option == "--robots") {
      robots.clear();
      std::stringstream names(argv[i + 1]);
      for (std::string name; std::getline(names, name, ',');) robots.push_back(name);
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
    for (int i = 0; i < seeds; ++i) {
      const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
      const Figure1Result result = RunFigure1(system, seed, robots);
      std::cout << fmt::format("{:4}  {:5}  {:14}  {:7.3f}  {:9.2f}  {:2}/{:2}  {:7.1f}  {}", seed,
                               result.exact ? "yes" : "no", result.false_closures, result.final_error,
                               result.final_yaw_error * kDegrees, result.inside, result.samples, result.seconds,
                               result.graph)
                << std::endl;
      exact += result.exact ? 1 : 0;
      false_closures += result.false_closures;
      samples += result.samples;
      inside += result.inside;
      errors.push_back(result.final_error);
      yaw_errors.push_back(result.final_yaw_error * kDegrees);
    }
  } catch (const std::exception& error) {
    std::cerr << "figure1_seeds: " << error.what() << '\n';
    return 2;
  }
  std::cout << fmt::format(
      "{} of {} graphs exact, {} false closures; final pose error: median {:.3f} m, {:.2f} deg; truth inside the 95 % "
      "ellipse: {:.1f} % of {} samples\n",
      exact, seeds, false_closures, MedianOf(errors), MedianOf(yaw_errors), 100.0 * inside / std::max(samples, 1),
      samples);
  return exact * 20 >= seeds * 19 && false_closures == 0 ? 0 : 1;
}

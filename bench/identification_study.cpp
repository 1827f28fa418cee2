#include "support/identification_study.hpp"

#include <cstdlib>
#include <string>

#include <fmt/core.h>

// Identifies simulated motors with hidden parameters, and counts how often the truth lies within
// the 99 % interval: identification_study [devices] [seed]
int main(int argc, char** argv) {
  using namespace gyrator;
  const StudyBench bench =
      argc > 1 && std::string(argv[1]) == "twin" ? StudyBench::twin : StudyBench::own;
  const int devices = argc > 2 ? std::atoi(argv[2]) : 50;
  const auto seed = static_cast<std::uint64_t>(argc > 3 ? std::atoll(argv[3]) : 1);
  fmt::print("{}", describe(run_identification_study(bench, devices, seed, true)));
  return 0;
}

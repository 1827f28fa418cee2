#include "support/identification_study.hpp"

#include "gyrator/core/random_stream.hpp"
#include "gyrator/identification/identification.hpp"

#include <cstdlib>

#include <fmt/core.h>

// Identifies simulated motors with hidden parameters, and counts how often the truth lies within
// the 99 % interval: identification_study [devices] [seed]
int main(int argc, char** argv) {
  const int devices = argc > 1 ? std::atoi(argv[1]) : 50;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  const gyrator::IdentificationStudy study = gyrator::run_identification_study(devices, seed, true);
  fmt::print("{}", gyrator::describe(study));
  return 0;
}

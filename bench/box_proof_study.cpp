// Guaranteed verdicts against single devices: every example that is proved passive over its box of
// parts, at random points and all corners of the box by the point proof.
//
//   box_proof_study [--points 10000] [--seed 1]
//
// Exit code 1 if a point of a proved box is not passive.

#include <chrono>
#include <cstdlib>
#include <cstring>

#include <fmt/core.h>

#include "../tests/support/box_examples.hpp"

namespace {

using namespace gyrator;
using namespace gyrator::testing;

// Random points, then corners.
int count_failures(const BoxExample& example, int points, std::uint64_t seed) {
  RandomStream random(seed, 0);
  int failures = 0;
  for (int i = 0; i < points; ++i) {
    if (!is_passive_at(example, example.values_at(example.draw_places(random)))) ++failures;
  }
  const std::size_t parts = example.parts.center.size();
  for (unsigned corner = 0; corner < 1U << parts; ++corner) {
    std::vector<double> places;
    for (std::size_t i = 0; i < parts; ++i) places.push_back((corner >> i & 1U) != 0 ? 1 : -1);
    if (!is_passive_at(example, example.values_at(places))) ++failures;
  }
  return failures;
}

}  // namespace

int main(int argc, char** argv) {
  int points = 10000;
  std::uint64_t seed = 1;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--points") == 0) points = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--seed") == 0) seed = std::strtoull(argv[i + 1], nullptr, 10);
  }
  int failures = 0;
  for (const BoxExample& example : list_box_examples()) {
    const auto start = std::chrono::steady_clock::now();
    const BoxProof proof = prove_box(example.maker, example.parts, example.sampling, example.law());
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    const char* verdict = proof.outcome == BoxOutcome::passive       ? "passive"
                          : proof.outcome == BoxOutcome::not_passive ? "not passive"
                                                                     : "undecided";
    fmt::print("{:<30} {:<12} {:>6} boxes {:>8} intervals {:>8.2f} s", example.name, verdict,
               proof.boxes, proof.intervals, spent.count());
    if (proof.outcome == BoxOutcome::passive) {
      const int failed = count_failures(example, points, seed);
      fmt::print("   {} of {} points and all corners fail", failed, points);
      failures += failed;
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
  return failures == 0 ? 0 : 1;
}

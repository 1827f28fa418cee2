// How safe and how tight the exact aliased disk is, on random loops of every linear kind of drive.
//
//   random_loop_study [--devices 100] [--seed 1] [--operators 60] [--kind rc]
//
// devices per kind: at 0.99 of the exact disk's limit the verdict must be passive, and no passive
// operator may break the loop: those drawn, and the counterexample found at 1.03. At 1.01 it must
// not be passive; at 1.03 a counterexample is sought, and where none is found, at which share of
// the limit one is. Exit code 1 if an operator broke a loop below the limit or a verdict was wrong.

#include <chrono>
#include <cstdlib>
#include <cstring>

#include "../tests/reference/random_loops.hpp"

namespace {

using namespace gyrator;
using namespace gyrator::reference;

struct Options {
  int devices = 100;
  std::uint64_t seed = 1;
  int operators = 60;
  std::string kind;
};

Options read_options(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const double value = std::atof(argv[i + 1]);
    if (std::strcmp(argv[i], "--devices") == 0) options.devices = static_cast<int>(value);
    if (std::strcmp(argv[i], "--seed") == 0) options.seed = static_cast<std::uint64_t>(value);
    if (std::strcmp(argv[i], "--operators") == 0) options.operators = static_cast<int>(value);
    if (std::strcmp(argv[i], "--kind") == 0) options.kind = argv[i + 1];
  }
  return options;
}

struct Tally {
  int devices = 0, rejected = 0, sound = 0, refused = 0, found = 0, plain = 0;
  double search_seconds = 0, slowest = 0, least_growth = 1;
  std::vector<std::string> missing, failures;

  void add(const Tally& other) {
    devices += other.devices;
    rejected += other.rejected;
    sound += other.sound;
    refused += other.refused;
    found += other.found;
    plain += other.plain;
    search_seconds += other.search_seconds;
    slowest = std::max(slowest, other.slowest);
    least_growth = std::min(least_growth, other.least_growth);
  }
  void print(const std::string& kind) const {
    fmt::print("{:<24}{:>8}{:>9}{:>8}{:>9}{:>8}{:>8}{:>8.1f}{:>10.3f}{:>9.3f}{:>10.1e}\n", kind,
               devices, rejected, sound, refused, found, plain, 100.0 * found / devices,
               search_seconds / devices, slowest, least_growth);
    std::fflush(stdout);
  }
};

Verdict judge_timed(const PassivityModel& model, Tally& tally) {
  const auto start = std::chrono::steady_clock::now();
  Verdict verdict = judge_passivity(model);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  tally.search_seconds += taken.count();
  tally.slowest = std::max(tally.slowest, taken.count());
  return verdict;
}

// The smallest of a few shares of the limit at which a counterexample is found.
std::string find_share(const RandomLoop& loop) {
  for (const double share : {1.05, 1.1, 1.2, 1.5, 2.0, 5.0})
    if (judge_passivity(loop.model(share)).counterexample) return fmt::format("{}", share);
  return "none up to 5";
}

void judge_loop(const RandomLoop& loop, int count, Tally& tally) {
  const auto fail = [&](const std::string& what) {
    tally.failures.push_back(what + ": " + loop.describe());
  };
  ++tally.devices;
  const Verdict above = judge_timed(loop.model(1.03), tally);
  std::optional<MassSpringDamper> example;
  if (above.counterexample) {
    example = above.counterexample->held_by;
    ++tally.found;
    tally.plain += example->resonators.empty();
    tally.least_growth = std::min(tally.least_growth, above.counterexample->spectral_radius - 1);
  } else {
    tally.missing.push_back(loop.describe() + "; found at " + find_share(loop));
  }
  if (judge_passivity(loop.model(1.01), false).passive) {
    fail("passive at 1.01");
  } else {
    ++tally.refused;
  }
  bool sound = judge_passivity(loop.model(0.99), false).passive;
  if (!sound) fail("not passive at 0.99");
  Random random(loop.seed + 1);
  std::vector<MassSpringDamper> operators = draw_passive_operators(random, loop, count, example);
  if (example) operators.push_back(*example);
  for (const MassSpringDamper& held_by : operators) {
    const double radius = loop.spectral_radius(0.99, held_by);
    if (radius <= 1 + stability_tolerance) continue;
    sound = false;
    fail(
        fmt::format("broken at 0.99, spectral radius 1 + {:.3g} by inertia {:.6g} damping {:.6g} "
                    "stiffness {:.6g} and {} resonators",
                    radius - 1, held_by.inertia, held_by.damping, held_by.stiffness,
                    held_by.resonators.size()));
    break;
  }
  tally.sound += sound;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = read_options(argc, argv);
  fmt::print("{:<24}{:>8}{:>9}{:>8}{:>9}{:>8}{:>8}{:>8}{:>10}{:>9}{:>10}\n", "kind", "devices",
             "rejected", "sound", "refused", "found", "plain", "%", "s/search", "slowest",
             "growth");
  Tally all;
  for (const DampingKind& kind : make_loop_kinds()) {
    if (!options.kind.empty() && kind.name != options.kind) continue;
    Tally tally;
    std::uint64_t seed = 1'000'000 * options.seed;
    while (tally.devices < options.devices && tally.rejected <= 50 * options.devices) {
      if (const auto loop = draw_loop(kind, seed++)) {
        judge_loop(*loop, options.operators, tally);
      } else {
        ++tally.rejected;
      }
    }
    tally.print(kind.name);
    for (const auto& text : tally.missing) fmt::print("  no counterexample at 1.03: {}\n", text);
    for (const auto& text : tally.failures) fmt::print("  FAILURE {}\n", text);
    all.add(tally);
    all.failures.insert(all.failures.end(), tally.failures.begin(), tally.failures.end());
  }
  all.print("all");
  return all.failures.empty() ? 0 : 1;
}

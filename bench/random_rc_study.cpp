// How safe and how tight the exact aliased disk is, on random RC-damped devices.
//
//   random_rc_study [--devices 200] [--seed 1] [--operators 400] [--samples 6000000]
//
// (a) at 0.97 of the exact-disk limit: counts the passive operators that break the loop (none may);
// (b) at 1.03: counts the devices for which a lossless operator that breaks it is found, each
// checked
//     by a simulated run that diverges, of at most so many samples.
// Exit code 1 if an operator broke a loop below the limit or a counterexample's run did not
// diverge.

#include <chrono>
#include <cstdlib>
#include <cstring>

#include "../tests/reference/random_rc.hpp"

namespace {

using namespace gyrator;
using namespace gyrator::reference;

struct Options {
  int devices = 200;
  std::uint64_t seed = 1;
  int operators = 400;
  double samples = 6e6;
};

Options read_options(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const double value = std::atof(argv[i + 1]);
    if (std::strcmp(argv[i], "--devices") == 0) options.devices = static_cast<int>(value);
    if (std::strcmp(argv[i], "--seed") == 0) options.seed = static_cast<std::uint64_t>(value);
    if (std::strcmp(argv[i], "--operators") == 0) options.operators = static_cast<int>(value);
    if (std::strcmp(argv[i], "--samples") == 0) options.samples = value;
  }
  return options;
}

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct Band {
  const char* name;
  double from, to;  // shares of Nyquist
};
constexpr Band bands[] = {
    {"low frequency", 0, 0.01}, {"in between", 0.01, 0.99}, {"Nyquist", 0.99, 2}};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

struct Tally {
  int devices = 0, found = 0, plain = 0, resonators = 0, diverge = 0, too_slow = 0;
  std::size_t most_resonators = 0;
  std::vector<double> growth, allowed;
};

// One device: (a), (b) and what there is to say about it.
class Study {
 public:
  explicit Study(const Options& options) : options_(options), random_(options.seed + 1) {}

  void judge(const RcCase& c) {
    Tally& tally = tallies_[band_of(c)];
    ++tally.devices;
    tally.allowed.push_back(c.textbook / c.limit);

    const Stopwatch above_watch;
    const Verdict above = judge_passivity(c.model(1.03));
    search_seconds_ += above_watch.seconds();
    if (above.passive) fail("passive at 1.03", c);
    if (above.counterexample) {
      book(tally, c, *above.counterexample);
    } else {
      missing_.push_back(c.describe());
    }

    const Stopwatch below_watch;
    if (!judge_passivity(c.model(0.97), false).passive) fail("not passive at 0.97", c);
    auto operators = draw_operators(random_, c, options_.operators);
    if (above.counterexample) operators.push_back(above.counterexample->held_by);
    for (const MassSpringDamper& held_by : operators) {
      ++tried_;
      const double radius = find_radius(c, 0.97, held_by);
      if (radius > 1 + stability_tolerance)
        fail(fmt::format("broken at 0.97, spectral radius {:.9f}", radius), c);
    }
    operator_seconds_ += below_watch.seconds();
  }

  int report(const RcCases& drawn) const {
    fmt::print(
        "{} devices from seed {} ({} more allow no stiffness at the virtual damping drawn)\n\n",
        drawn.cases.size(), options_.seed, drawn.infeasible);
    fmt::print("{:<14}{:>8}{:>7}{:>12}{:>12}{:>6}{:>10}{:>10}{:>22}{:>24}\n", "binds at", "devices",
               "found", "mass/spring", "resonators", "most", "diverge", "too slow",
               "growth/sample 0/50 %", "[8.46]/disk 0/50/100 %");
    Tally all;
    for (std::size_t i = 0; i < std::size(bands); ++i) {
      print(bands[i].name, tallies_[i]);
      add(all, tallies_[i]);
    }
    print("all", all);
    fmt::print("\n(a) at 0.97: {} operators tried, {} failures\n", tried_, failures_.size());
    fmt::print(
        "(b) at 1.03: counterexample for {} of {} devices ({:.1f} %), {} runs diverge, {} too slow "
        "to run\n",
        all.found, all.devices, 100.0 * all.found / all.devices, all.diverge, all.too_slow);
    fmt::print("time: {:.1f} s verdicts with search, {:.1f} s runs, {:.1f} s operators\n",
               search_seconds_, run_seconds_, operator_seconds_);
    for (const auto& text : missing_) fmt::print("no counterexample: {}\n", text);
    for (const auto& text : failures_) fmt::print("FAILURE {}\n", text);
    return failures_.empty() ? 0 : 1;
  }

 private:
  static std::size_t band_of(const RcCase& c) {
    std::size_t band = 0;
    while (c.share_of_nyquist >= bands[band].to) ++band;
    return band;
  }

  void fail(const std::string& what, const RcCase& c) {
    failures_.push_back(what + ": " + c.describe());
  }

  void book(Tally& tally, const RcCase& c, const Counterexample& counterexample) {
    ++tally.found;
    const std::size_t resonators = counterexample.held_by.resonators.size();
    ++(resonators == 0 ? tally.plain : tally.resonators);
    tally.most_resonators = std::max(tally.most_resonators, resonators);
    tally.growth.push_back(counterexample.spectral_radius - 1);
    const Stopwatch watch;
    const RunResult outcome = run_counterexample(c, 1.03, counterexample, options_.samples);
    run_seconds_ += watch.seconds();
    tally.diverge += outcome == RunResult::diverges;
    tally.too_slow += outcome == RunResult::too_slow;
    if (outcome == RunResult::does_not_diverge) {
      fail(fmt::format("run does not diverge, spectral radius {:.9f}, {} resonators",
                       counterexample.spectral_radius, resonators),
           c);
    }
  }

  static void add(Tally& sum, const Tally& part) {
    sum.devices += part.devices;
    sum.found += part.found;
    sum.plain += part.plain;
    sum.resonators += part.resonators;
    sum.diverge += part.diverge;
    sum.too_slow += part.too_slow;
    sum.most_resonators = std::max(sum.most_resonators, part.most_resonators);
    sum.growth.insert(sum.growth.end(), part.growth.begin(), part.growth.end());
    sum.allowed.insert(sum.allowed.end(), part.allowed.begin(), part.allowed.end());
  }

  static void print(const char* name, const Tally& t) {
    fmt::print(
        "{:<14}{:>8}{:>7}{:>12}{:>12}{:>6}{:>10}{:>10}{:>13.1e}{:>9.1e}{:>10.3f}{:>7.3f}{:>7.3g}\n",
        name, t.devices, t.found, t.plain, t.resonators, t.most_resonators, t.diverge, t.too_slow,
        quantile(t.growth, 0), quantile(t.growth, 0.5), quantile(t.allowed, 0),
        quantile(t.allowed, 0.5), quantile(t.allowed, 1));
  }

  Options options_;
  Random random_;
  Tally tallies_[std::size(bands)];
  long tried_ = 0;
  double search_seconds_ = 0, run_seconds_ = 0, operator_seconds_ = 0;
  std::vector<std::string> missing_, failures_;
};

}  // namespace

int main(int argc, char** argv) {
  const Options options = read_options(argc, argv);
  const RcCases drawn = draw_cases(options.devices, options.seed);
  Study study(options);
  for (const RcCase& c : drawn.cases) study.judge(c);
  return study.report(drawn);
}

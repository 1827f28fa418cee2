// Cost of one step of each velocity estimator, on a swing of 2 Hz as an encoder senses it.
#include <benchmark/benchmark.h>

#include "../tests/support/estimator_errors.hpp"

namespace {

using namespace gyrator;

std::vector<double> make_samples(double amplitude) {
  std::vector<double> samples;
  for (int k = 0; k < 4096; ++k)
    samples.push_back(
        estimator_errors::sense(amplitude * std::sin(2 * std::numbers::pi * k / 512)));
  return samples;
}

void run_steps(benchmark::State& state, const VelocityEstimator& estimator, double amplitude) {
  const std::vector<double> samples = make_samples(amplitude);
  RunningVelocityEstimator run(estimator, estimator_errors::period);
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(run.step(samples[k]));
    k = (k + 1) % samples.size();
  }
}

constexpr double q = estimator_errors::quantum;
constexpr double swing = 0.2;      // 1300 counts: windows of a few samples
constexpr double still = 0.9 * q;  // one count back and forth: whole windows

BENCHMARK_CAPTURE(run_steps, difference_1, DifferenceEstimator{1}, swing);
BENCHMARK_CAPTURE(run_steps, difference_1000, DifferenceEstimator{1000}, swing);
BENCHMARK_CAPTURE(run_steps, filtered_difference, FilteredDifferenceEstimator{50}, swing);
BENCHMARK_CAPTURE(run_steps, butterworth_2, (ButterworthEstimator{2, 50}), swing);
BENCHMARK_CAPTURE(run_steps, butterworth_8, (ButterworthEstimator{8, 50}), swing);
BENCHMARK_CAPTURE(run_steps, foaw_32_end, (AdaptiveWindowEstimator{q, 32, WindowFit::end}), swing);
BENCHMARK_CAPTURE(run_steps, foaw_32_best, (AdaptiveWindowEstimator{q, 32, WindowFit::best}),
                  swing);
BENCHMARK_CAPTURE(run_steps, foaw_32_best_whole_window,
                  (AdaptiveWindowEstimator{q, 32, WindowFit::best}), still);
BENCHMARK_CAPTURE(run_steps, levant, LevantEstimator{40}, swing);

}  // namespace

BENCHMARK_MAIN();

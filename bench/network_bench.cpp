// Cost of the network analyses over the number of nodes: docs/netlist-size.md.
#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/descriptor_response.hpp"
#include "gyrator/circuits/energy_forms.hpp"
#include "gyrator/circuits/hessenberg_response.hpp"
#include "gyrator/circuits/reduction.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include <benchmark/benchmark.h>

#include "network_models.hpp"

namespace {

using namespace gyrator;

enum Kind { rlc_ladder, rc_grid, sparse_grid };

bench::SizedNetwork make(const benchmark::State& state) {
  const int nodes = static_cast<int>(state.range(1));
  switch (state.range(0)) {
    case rlc_ladder:
      return bench::make_rlc_ladder(nodes);
    case rc_grid:
      return bench::make_rc_grid(nodes);
    default:
      return bench::make_rc_grid(nodes, 4);
  }
}

// 200 points over 0.01 Hz ... 100 kHz.
std::complex<double> point(int i) {
  return {0, 2 * std::numbers::pi * 0.01 * std::pow(10.0, 7.0 * i / 199)};
}
constexpr int points = 200;

void assembly(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(NetworkEquations(make(state).network).network());
}

void reduction(benchmark::State& state) {
  const NetworkEquations equations(make(state).network);
  for (auto _ : state) {
    const Reduction r = reduce(equations.descriptor());
    benchmark::DoNotOptimize(r.A.data());
    state.counters["states"] = static_cast<double>(r.A.rows());
  }
  state.counters["unknowns"] = static_cast<double>(equations.descriptor().size());
}

void response_dense(benchmark::State& state) {
  const NetworkEquations equations(make(state).network);
  for (auto _ : state) {
    for (int i = 0; i < points; ++i)
      benchmark::DoNotOptimize(solve_descriptor(equations.descriptor(), point(i)).data());
  }
}

void response_sparse(benchmark::State& state) {
  const NetworkEquations equations(make(state).network);
  for (auto _ : state) {
    DescriptorResponse response(equations.descriptor(), 0);
    for (int i = 0; i < points; ++i) benchmark::DoNotOptimize(response.solve(point(i)).data());
  }
}

void response_reduced(benchmark::State& state) {
  const auto sized = make(state);
  const NetworkEquations equations(sized.network);
  const Reduction r = reduce(equations.descriptor());
  const ReducedForm far = r.reduce(equations.across(sized.far));
  Eigen::MatrixXcd response_at;
  for (auto _ : state) {
    HessenbergResponse response({r.A, r.B, far.state, far.input});
    for (int i = 0; i < points; ++i) {
      response.evaluate(point(i), response_at);
      benchmark::DoNotOptimize(response_at.data());
    }
  }
}

// What a passivity verdict asks of the reduced network: 10^5 points with two inputs and outputs.
void alias_points(benchmark::State& state) {
  const auto n = static_cast<Eigen::Index>(state.range(0));
  auto sized = bench::make_rc_grid(static_cast<int>(n) + 1);
  sized.network.add("feed", ground, sized.far, CurrentSource{sized.network.add_input("j")});
  const NetworkEquations equations(sized.network);
  const Reduction r = reduce(equations.descriptor());
  const ReducedForm far = r.reduce(equations.across(sized.far));
  const ReducedForm near = r.reduce(equations.through(sized.source));
  StateSpace system{r.A, r.B, Eigen::MatrixXd(2, r.A.rows()), Eigen::MatrixXd(2, 2)};
  system.C << far.state, near.state;
  system.D << far.input, near.input;
  HessenbergResponse response(system);
  Eigen::MatrixXcd response_at;
  for (auto _ : state) {
    for (int i = 0; i < 100000; ++i) {
      response.evaluate(point(i % points), response_at);
      benchmark::DoNotOptimize(response_at.data());
    }
  }
}

void energy_forms(benchmark::State& state) {
  const NetworkEquations equations(make(state).network);
  const Reduction r = reduce(equations.descriptor());
  for (auto _ : state)
    benchmark::DoNotOptimize(build_energy_forms(equations, r, std::nullopt).stored.data());
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"kind", "nodes"})->Unit(benchmark::kMillisecond);
  for (const int kind : {rlc_ladder, rc_grid, sparse_grid})
    for (const int nodes : {10, 60, 200, 500}) b->Args({kind, nodes});
}

BENCHMARK(assembly)->Apply(sizes);
BENCHMARK(reduction)->Apply(sizes);
BENCHMARK(response_dense)->Apply(sizes);
BENCHMARK(response_sparse)->Apply(sizes);
BENCHMARK(response_reduced)->Apply(sizes);
BENCHMARK(alias_points)->ArgName("states")->Arg(4)->Arg(12)->Arg(60)->Unit(benchmark::kMillisecond);
BENCHMARK(energy_forms)->Apply(sizes);

}  // namespace

BENCHMARK_MAIN();

#include "gyrator/lanes/lane_block.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrator {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

static_assert(samples_between_looks == samples_between_checks);

LaneKernel find_kernel(LaneInstructions instructions, const LaneProgram& program) {
#if defined(__x86_64__)
  if (instructions == LaneInstructions::avx512) return lane_avx512::find_kernel(program);
  if (instructions == LaneInstructions::avx2) return lane_avx2::find_kernel(program);
#else
  (void)instructions;
#endif
  return lane_baseline::find_kernel(program);
}

LaneCrossingsFinder find_crossings_finder(LaneInstructions instructions) {
#if defined(__x86_64__)
  if (instructions == LaneInstructions::avx512) return lane_avx512::find_crossings;
  if (instructions == LaneInstructions::avx2) return lane_avx2::find_crossings;
#else
  (void)instructions;
#endif
  return lane_baseline::find_crossings;
}

// Which coordinate of the state a signal is; -1 where it is none.
int find_coordinate(const Eigen::RowVectorXd& row) {
  Eigen::Index at = 0;
  if (row.cwiseAbs().maxCoeff(&at) != 1 || row(at) != 1) return -1;
  return (row.array() != 0).count() == 1 ? static_cast<int>(at) : -1;
}

// Of a third of the rows: each second one at most.
std::size_t most_crossings(long rows) {
  return static_cast<std::size_t>(rows / 3 / 2 + 1);
}

bool is_difference(const DiscreteStateSpace& law) {
  return law.states() == 1 && law.A(0, 0) == 0 && law.B(0) == 1;
}

}  // namespace

LaneBlock::LaneBlock(const LaneScene& scene, const LaneDesign& example,
                     LaneInstructions instructions, Positions kept)
    : scene_(scene) {
  prepare_scene(scene);
  const long rows = program_.samples + 1;
  program_.last_third = rows - rows / 3;
  program_.last_sixth = rows - rows / 3 / 2;
  program_.first_position = kept == Positions::all ? 0 : std::min(program_.last_third, rows - 1);
  prepare_program(example);
  kernel_ = find_kernel(instructions, program_);
  find_crossings_ = find_crossings_finder(instructions);
  const auto n = static_cast<std::size_t>(program_.states);
  const auto m = static_cast<std::size_t>(program_.law_states);
  constexpr auto lanes = static_cast<std::size_t>(lanes_per_block);
  propagate_.assign(n * (n + 3) * lanes, 0);
  signals_.assign(3 * n * lanes, 0);
  law_.assign((m + 1) * (m + 1) * lanes, 0);
  pushing_.assign(lanes, 0);
  xi_.assign(n * lanes, 0);
  law_state_.assign(std::max<std::size_t>(1, m) * lanes, 0);
  commands_.assign(static_cast<std::size_t>(program_.whole_delay + 2) * lanes, 0);
  reference_.assign(lanes, 0);
  velocity_.assign(static_cast<std::size_t>(rows) * lanes, 0);
  // The kernel writes the rows before the first over one another: there is always one.
  position_.assign(static_cast<std::size_t>(std::max(1L, rows - program_.first_position)) * lanes,
                   0);
  if (kept == Positions::all) return;
  low_.assign(lane_stretches * lanes, 0);
  high_.assign(lane_stretches * lanes, 0);
  middle_.assign(lanes, 0);
  crossing_.assign(most_crossings(rows) * lanes, 0);
  swing_.assign(most_crossings(rows) * lanes, 0);
}

// What follows from sensor, clock and gesture alone.
void LaneBlock::prepare_scene(const LaneScene& scene) {
  const SimulationOptions& o = scene.options;
  program_.samples = floor_divide(o.duration, scene.sampling.period);
  if (program_.samples < 1)
    throw Error(ErrorCode::bad_input, "simulation/duration", "must be at least one sample period");
  program_.period = scene.sampling.period.to_double();
  program_.quantum = scene.sensor.quantum;
  program_.offset = scene.sensor.offset;
  program_.dac_quantum = o.dac.quantum;
  program_.dac_limit = o.dac.limit.value_or(infinity);
  program_.runaway_ratio = runaway_ratio;
  const auto samples = static_cast<std::size_t>(program_.samples);
  efforts_.assign(samples, o.external_effort);
  if (o.gesture) {
    RunningGesture gesture(*o.gesture, o.seed);
    const SampleClock clock(scene.sampling, o.seed);
    for (std::size_t k = 0; k < samples; ++k) {
      const auto tick = static_cast<std::int64_t>(k);
      efforts_[k] += gesture.mean_effort(clock.time_of_tick(tick), clock.time_of_tick(tick + 1),
                                         program_.period);
    }
  }
  program_.effort = efforts_.data();
  if (scene.sensor.noise > 0) {
    RandomStream stream(o.seed, noise_stream);
    noise_.resize(samples + 1);
    for (double& noise : noise_) noise = scene.sensor.noise * stream.normal();
    program_.noise = noise_.data();
  }
}

void LaneBlock::prepare_program(const LaneDesign& example) {
  const LanePlant& plant = *example.plant;
  program_.states = static_cast<int>(plant.states());
  program_.law_states = static_cast<int>(example.law.law.states());
  program_.law_is_difference = is_difference(example.law.law);
  program_.whole_delay = static_cast<int>(plant.delay.whole);
  program_.split = plant.delay.rest > 0;
  program_.contact_threshold = example.law.contact_threshold;
  program_.most_command = -example.law.least_effort;
  program_.sensed = find_coordinate(plant.sensed);
  program_.position = find_coordinate(plant.position);
  program_.velocity = find_coordinate(plant.velocity);
}

// The kernel is one program for all lanes.
void LaneBlock::check_kind(const LaneDesign& design) const {
  const LanePlant& plant = *design.plant;
  const bool alike =
      plant.states() == program_.states && design.law.law.states() == program_.law_states &&
      is_difference(design.law.law) == program_.law_is_difference &&
      design.law.contact_threshold == program_.contact_threshold &&
      -design.law.least_effort == program_.most_command &&
      plant.delay.whole == program_.whole_delay && (plant.delay.rest > 0) == program_.split &&
      find_coordinate(plant.sensed) == program_.sensed &&
      find_coordinate(plant.position) == program_.position &&
      find_coordinate(plant.velocity) == program_.velocity;
  if (alike) return;
  throw Error(ErrorCode::bad_input, "lanes",
              "designs of different kinds (states, delay, switch, signals) cannot be side by side");
}

void LaneBlock::set_plant(const LanePlant& plant, int lane) {
  const auto stride = static_cast<std::size_t>(program_.shared_plant ? 1 : lanes_per_block);
  std::size_t at = program_.shared_plant ? 0 : static_cast<std::size_t>(lane);
  for (Eigen::Index i = 0; i < plant.propagate.rows(); ++i) {
    for (Eigen::Index j = 0; j < plant.propagate.cols(); ++j, at += stride)
      propagate_[at] = plant.propagate(i, j);
  }
  at = static_cast<std::size_t>(lane);
  for (const auto* row : {&plant.sensed, &plant.position, &plant.velocity}) {
    for (Eigen::Index i = 0; i < row->size(); ++i, at += lanes_per_block) signals_[at] = (*row)(i);
  }
  pushing_[static_cast<std::size_t>(lane)] = plant.largest_push;
}

void LaneBlock::set_law(const LaneLaw& design, int lane) {
  const DiscreteStateSpace& law = design.law;
  const Eigen::Index m = law.states();
  auto at = static_cast<std::size_t>(lane);
  const auto put = [&](double value) {
    law_[at] = value;
    at += lanes_per_block;
  };
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j < m; ++j) put(law.A(i, j));
    put(law.B(i));
  }
  for (Eigen::Index j = 0; j < m; ++j) put(-law.C(j));
  put(-law.D);
}

void LaneBlock::set_start(const LaneDesign& design, int lane) {
  const SimulationOptions& o = scene_.options;
  const LanePlant& plant = *design.plant;
  const Eigen::VectorXd xi = plant.initial_state(o.initial_position, o.initial_velocity);
  auto at = static_cast<std::size_t>(lane);
  for (Eigen::Index i = 0; i < xi.size(); ++i, at += lanes_per_block) xi_[at] = xi(i);
  // The law starts as if its first sample had been there for ever.
  const double first =
      round_to_multiple(plant.sensed.dot(xi) + (noise_.empty() ? 0 : noise_.front()),
                        scene_.sensor.quantum) +
      scene_.sensor.offset;
  at = static_cast<std::size_t>(lane);
  for (Eigen::Index i = 0; i < design.law.settled_at_one.size(); ++i, at += lanes_per_block)
    law_state_[at] = first * design.law.settled_at_one(i);
}

void LaneBlock::run(std::span<const LaneDesign> designs) {
  const bool shared = std::all_of(designs.begin(), designs.end(), [&](const LaneDesign& d) {
    return d.plant == designs.front().plant;
  });
  const bool is_loaded = shared && designs.front().plant == loaded_;
  program_.shared_plant = shared;
  for (int lane = 0; lane < lanes_per_block; ++lane) {
    // Lanes that are left over repeat the last design.
    const auto i = std::min(static_cast<std::size_t>(lane), designs.size() - 1);
    check_kind(designs[i]);
    if (!is_loaded) set_plant(*designs[i].plant, lane);
    set_law(designs[i].law, lane);
    set_start(designs[i], lane);
  }
  loaded_ = shared ? designs.front().plant : nullptr;
  std::fill(commands_.begin(), commands_.end(), 0);
  std::fill(reference_.begin(), reference_.end(), 0);
  kernel_(program_, {propagate_.data(), signals_.data(), law_.data(), pushing_.data()},
          {xi_.data(), law_state_.data(), commands_.data(), reference_.data()},
          {position_.data(), velocity_.data(), ends_.data(), end_rows_.data(),
           low_.empty() ? nullptr : low_.data(), low_.empty() ? nullptr : high_.data()});
}

LaneBlock::Range LaneBlock::range(LaneStretch stretch, int lane) const {
  const auto at =
      static_cast<std::size_t>(stretch) * lanes_per_block + static_cast<std::size_t>(lane);
  return {low_[at], high_[at]};
}

RunSizes LaneBlock::sizes(int lane) const {
  const Range early = range(LaneStretch::early, lane);
  const Range before_last = range(LaneStretch::before_last, lane);
  const Range last = range(LaneStretch::last, lane);
  const Range position = range(LaneStretch::position, lane);
  const double high = std::max({early.high, before_last.high, last.high});
  const double low = std::min({early.low, before_last.low, last.low});
  return {static_cast<std::size_t>(program_.samples + 1), (high - low) / 2,
          (last.high - last.low) / 2, (position.high - position.low) / 2};
}

void LaneBlock::find_cycles(const std::array<bool, lanes_per_block>& wanted) {
  for (int lane = 0; lane < lanes_per_block; ++lane) {
    const Range before_last = range(LaneStretch::before_last, lane);
    const Range last = range(LaneStretch::last, lane);
    middle_[static_cast<std::size_t>(lane)] =
        (std::min(before_last.low, last.low) + std::max(before_last.high, last.high)) / 2;
  }
  const std::size_t most = most_crossings(program_.samples + 1);
  std::array<long, lanes_per_block> counts{};
  find_crossings_(program_, velocity_.data(),
                  {middle_.data(), wanted.data(), static_cast<long>(most), crossing_.data(),
                   swing_.data(), counts.data()});
  for (std::size_t lane = 0; lane < lanes_per_block; ++lane) {
    cycles_[lane].clear();
    const double* crossing = crossing_.data() + lane * most;
    for (long i = 0; i + 1 < counts[lane]; ++i)
      cycles_[lane].push_back(
          {crossing[i], crossing[i + 1], swing_[lane * most + static_cast<std::size_t>(i)]});
  }
}

}  // namespace gyrator

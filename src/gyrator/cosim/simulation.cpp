#include "gyrator/cosim/simulation.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/cosim/sampled_plant.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {
namespace {

constexpr double runaway_ratio = 1e9;
constexpr long samples_between_checks = 16;
constexpr long samples_between_reports = 4096;
constexpr double most_trace_bytes = 4e9;
constexpr std::int64_t most_delay_periods = 10'000'000;

double quantize(double position, const Sensor& sensor) {
  if (sensor.quantum > 0) position = sensor.quantum * std::floor(position / sensor.quantum + 0.5);
  return position + sensor.offset;
}

// Commands on their way: the newest `whole` + 1, oldest first out.
class CommandLine {
 public:
  explicit CommandLine(std::int64_t whole) : ring_(static_cast<std::size_t>(whole) + 1, 0.0) {}

  // Takes u[k] and returns u[k - whole].
  double pass(double command) {
    ring_[at_] = command;
    at_ = (at_ + 1) % ring_.size();
    return ring_[at_];
  }

 private:
  std::vector<double> ring_;
  std::size_t at_ = 0;
};

class Run {
 public:
  Run(const Plant& plant, const Sensor& sensor, const Controller& controller,
      const Sampling& sampling, const SimulationOptions& options)
      : plant_(plant),
        sensor_(sensor),
        sampling_(sampling),
        options_(options),
        delay_(split_delay(sampling)),
        engine_(make_engine(options.engine, plant, options.engine_options)),
        controller_(controller, sampling.period.to_double(), options.initial_position),
        line_(checked_delay(delay_.whole)),
        u_(0, options.external_effort),
        steps_(floor_divide(options.duration, sampling.period)) {
    if (steps_ < 1) {
      throw Error(ErrorCode::bad_input, "simulation/duration",
                  fmt::format("{:g} s: must be at least one sample period, {:g} s",
                              options.duration.to_double(), sampling.period.to_double()));
    }
    if (std::abs(plant.sensor_position.input(0)) > 0) {
      throw Error(ErrorCode::numerical, "sensor",
                  "the sensed position would jump with the command");
    }
    state_.xi = plant.initial_state(options.initial_position, options.initial_velocity);
    jumps_cost_energy_ = !plant.energy.source_jump.isZero(0);
    jump_.resize(plant.states() + 2 * plant.inputs());
    z_.resize(plant.states() + plant.inputs());
  }

  TimeRun go() {
    prepare_trace();
    run_.energy.stored_initially = stored();
    const bool split = delay_.rest > 0;
    const bool in_between = options_.trace_step.has_value();
    const int whole = engine_->prepare(split ? delay_.period - delay_.rest : delay_.period);
    const int first = split ? engine_->prepare(delay_.rest) : -1;

    long k = 0;
    for (; k < steps_ && !run_.stopped_early; ++k) {
      const double measured = quantize(plant_.sensor_position.state.dot(state_.xi), sensor_);
      const double command = controller_.step(measured);
      const double next = line_.pass(command);
      const double t = time_at(k);
      if (recording_ && k % options_.record_every == 0)
        record(t, measured, command, split ? u_(0) : next);
      if (in_between) {
        advance_in_between(k, next, measured, command);
      } else if (split) {
        engine_->advance(first, t, u_, state_);
        jump_to(next);
        engine_->advance(whole, t + delay_.rest, u_, state_);
      } else {
        jump_to(next);
        engine_->advance(whole, t, u_, state_);
      }
      if (k % samples_between_checks == 0) check_size(k);
      if (options_.on_progress && k % samples_between_reports == 0 && k > 0)
        options_.on_progress(samples_between_reports);
    }
    finish(k);
    return std::move(run_);
  }

 private:
  static std::int64_t checked_delay(std::int64_t periods) {
    if (periods <= most_delay_periods) return periods;
    throw Error(
        ErrorCode::bad_input, "sampling/delay",
        fmt::format("{} sample periods: at most {} can be simulated", periods, most_delay_periods));
  }

  // k num / den, correctly rounded while k num is below 2^53.
  double time_at(long k) const {
    return static_cast<double>(k) * static_cast<double>(sampling_.period.num()) /
           static_cast<double>(sampling_.period.den());
  }

  // All that signals and energies are functions of beside ξ, while `command` is held.
  const Eigen::VectorXd& inputs_at(double command) {
    return engine_->inputs(Eigen::Vector2d(command, u_(1)), state_);
  }

  // Whether a step of the command shows in a signal at once.
  bool jumps(const Signal& signal) const {
    if (signal.input(0) != 0) return true;
    return plant_.nonlinear && !signal.input.segment(2, signal.input.size() - 3).isZero(0);
  }

  void jump_to(double command) {
    if (command == u_(0)) return;
    if (jumps_cost_energy_ && options_.engine_options.ledger) {
      before_ = inputs_at(u_(0));
      jump_ << state_.xi, before_, inputs_at(command);
      state_.source_work += jump_.dot(plant_.energy.source_jump * jump_);
    }
    u_(0) = command;
  }

  // Period k with rows every trace step and, before and after the jump, at the hold's edge.
  void advance_in_between(long k, double next, double measured, double command) {
    const Rational start = sampling_.period * Rational(k);
    const Rational end = start + sampling_.period;
    const Rational edge = start + sampling_.delay -
                          Rational(delay_.whole) * sampling_.period;  // where `next` takes effect
    const Rational step = *options_.trace_step;
    Rational now = start;
    if (edge == start) jump_to(next);
    for (std::int64_t i = floor_divide(start, step) + 1; now < end; ++i) {
      Rational stop = std::min(Rational(i) * step, end);
      if (now < edge && stop >= edge) {
        const bool coincide = stop == edge;
        stop = edge;
        if (!coincide) --i;
      }
      const Rational length = stop - now;
      engine_->advance(engine_->prepare(length.to_double()), now.to_double(), u_, state_);
      now = stop;
      if (now == edge && edge != start) {
        if (recording_) record(now.to_double(), measured, command, next);
        jump_to(next);
      }
      if (now < end && recording_) record(now.to_double(), measured, command, u_(0));
    }
  }

  void prepare_trace() {
    recording_ = options_.record;
    auto& names = run_.trace.names;
    names = {"time_s", "position", "velocity", "effort", "command"};
    for (const auto& signal : plant_.others) names.push_back(signal.name);
    const bool wave = plant_.sensor_position.name == wave_integral_name;
    names.insert(names.end(), {wave ? "measured_wave_integral" : "measured_position",
                               "held_command", "held_command_after"});
    for (const auto& signal : plant_.others) {
      if (jumps(signal)) names.push_back(signal.name + "_after");
    }
    if (jumps(plant_.port_effort)) names.emplace_back("effort_after");
    if (options_.engine_options.ledger) {
      names.insert(names.end(),
                   {"energy_operator", "energy_source", "energy_stored", "energy_dissipated"});
    }
    run_.trace.columns.assign(names.size(), {});
    const double step = options_.trace_step
                            ? std::min(options_.trace_step->to_double(), delay_.period)
                            : delay_.period;
    const double rows = delay_.period * static_cast<double>(steps_) / step /
                        static_cast<double>(options_.record_every);
    const double bytes = rows * static_cast<double>(names.size() * sizeof(double));
    if (recording_ && bytes > most_trace_bytes) {
      throw Error(
          ErrorCode::bad_input, "simulation/duration",
          fmt::format("{:g} s: the trace would have {:.3g} rows and take {:.3g} GB of memory: at "
                      "most {:g} GB; "
                      "shorten the duration or lengthen the trace step",
                      options_.duration.to_double(), rows, bytes * 1e-9, most_trace_bytes * 1e-9));
    }
    if (recording_ && !options_.trace_step) {
      for (auto& column : run_.trace.columns) column.reserve(static_cast<std::size_t>(steps_) + 1);
    }
  }

  void record(double time, double measured, double command, double held_after) {
    std::size_t at = 0;
    auto& columns = run_.trace.columns;
    const auto put = [&](double value) { columns[at++].push_back(value); };
    before_ = inputs_at(u_(0));
    after_ = inputs_at(held_after);
    const auto value = [&](const Signal& s, bool after) {
      return s.value(state_.xi, after ? after_ : before_);
    };
    put(time);
    put(value(plant_.port_position, false));
    put(value(plant_.port_velocity, false));
    put(value(plant_.port_effort, false));
    put(command);
    for (const auto& signal : plant_.others) put(value(signal, false));
    put(measured);
    put(u_(0));
    put(held_after);
    for (const auto& signal : plant_.others) {
      if (jumps(signal)) put(value(signal, true));
    }
    if (jumps(plant_.port_effort)) put(value(plant_.port_effort, true));
    if (options_.engine_options.ledger) {
      put(state_.operator_work);
      put(state_.source_work);
      put(stored());
      put(state_.dissipated);
    }
  }

  double stored() {
    z_ << state_.xi, inputs_at(u_(0));
    return z_.dot(plant_.energy.stored * z_);
  }

  void check_size(long k) {
    throw_if_interrupted(fmt::format("t = {:g} s", time_at(k)));
    const Eigen::Index temperatures =
        plant_.nonlinear ? static_cast<Eigen::Index>(plant_.nonlinear->thermal.size()) : 0;
    const double size = state_.xi.head(plant_.states() - temperatures).cwiseAbs().maxCoeff();
    if (k <= samples_between_checks) reference_size_ = std::max(reference_size_, size);
    if (!std::isfinite(size) || (reference_size_ > 0 && size > runaway_ratio * reference_size_)) {
      run_.stopped_early = true;
    }
  }

  void finish(long steps) {
    run_.steps = steps;
    run_.engine = options_.engine;
    run_.events = state_.events;
    run_.final_time_s = time_at(steps);
    auto& e = run_.energy;
    e.operator_work = state_.operator_work;
    e.source = state_.source_work;
    e.dissipated = state_.dissipated;
    e.stored = stored();
    e.residual = e.operator_work + e.source - (e.stored - e.stored_initially) - e.dissipated;
    if (!recording_) return;
    const double measured = quantize(plant_.sensor_position.state.dot(state_.xi), sensor_);
    const double command = controller_.step(measured);
    record(run_.final_time_s, measured, command, delay_.rest > 0 ? u_(0) : line_.pass(command));
    classify_run();
  }

  void classify_run() {
    const auto& time = run_.trace.column("time_s");
    std::vector<double> position;
    std::vector<double> velocity;
    // Rows in between do not count: the classification is the same with and without a trace step.
    long next = 0;
    for (std::size_t row = 0; row < time.size(); ++row) {
      if (time[row] < time_at(next)) continue;  // rows in between are no multiple of the period
      position.push_back(run_.trace.column("position")[row]);
      velocity.push_back(run_.trace.column("velocity")[row]);
      next += options_.record_every;
    }
    run_.classification =
        classify(position, velocity, delay_.period * static_cast<double>(options_.record_every),
                 run_.stopped_early, options_.classification);
  }

  const Plant& plant_;
  Sensor sensor_;
  Sampling sampling_;
  const SimulationOptions& options_;
  SplitDelay delay_;
  std::unique_ptr<Engine> engine_;
  RunningController controller_;
  CommandLine line_;
  Eigen::Vector2d u_;
  std::int64_t steps_;
  PlantState state_;
  TimeRun run_;
  bool recording_ = true;
  bool jumps_cost_energy_ = false;
  double reference_size_ = 0;
  Eigen::VectorXd jump_, z_, before_, after_;
};

}  // namespace

const std::vector<double>& Trace::column(const std::string& name) const {
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) {
    throw Error(ErrorCode::bad_input, "trace",
                fmt::format("no column \"{}\": there are {}", name, fmt::join(names, ", ")));
  }
  return columns[static_cast<std::size_t>(it - names.begin())];
}

TimeRun simulate(const Plant& plant, const Sensor& sensor, const Controller& controller,
                 const Sampling& sampling, const SimulationOptions& options) {
  return Run(plant, sensor, controller, sampling, options).go();
}

}  // namespace gyrator

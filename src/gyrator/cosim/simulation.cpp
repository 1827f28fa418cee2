#include "gyrator/cosim/simulation.hpp"

#include "gyrator/core/interrupt.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr long samples_between_reports = 4096;
constexpr double most_trace_bytes = 4e9;

class Run {
 public:
  Run(const Plant& plant, const Sensor& sensor, const Controller& controller,
      const Sampling& sampling, const SimulationOptions& options)
      : plant_(plant),
        sampling_(sampling),
        options_(options),
        delay_(split_delay(sampling)),
        engine_(make_engine(options.engine, plant, options.engine_options)),
        sensor_(sensor, options.seed),
        controller_(controller, sampling.period.to_double(), options.initial_position),
        clock_(sampling, options.seed),
        path_(sampling, delay_),
        u_(0, options.external_effort),
        steps_(floor_divide(options.duration, sampling.period)),
        recorder_(plant, *engine_, controller_, run_.trace,
                  {options.engine_options.ledger, options.gesture.has_value()}) {
    if (steps_ < 1) {
      throw Error(ErrorCode::bad_input, "simulation/duration",
                  fmt::format("{:g} s: must be at least one sample period, {:g} s",
                              options.duration.to_double(), sampling.period.to_double()));
    }
    if (std::abs(plant.sensor_position.input(0)) > 0) {
      throw Error(ErrorCode::numerical, "sensor",
                  "the sensed position would jump with the command");
    }
    if (options.gesture) gesture_.emplace(*options.gesture, options.seed);
    state_.xi = plant.initial_state(options.initial_position, options.initial_velocity);
    if (plant.states() > 0) pushing_ = plant.B.col(1).cwiseAbs().maxCoeff();
    jumps_cost_energy_ = options.engine_options.ledger && !plant.energy.source_jump.isZero(0);
    jump_.resize(plant.states() + 2 * plant.inputs());
    at_sample_ = state_;
    check_trace_size();
  }

  TimeRun go() {
    run_.energy.stored_initially = recorder_.stored(u_, state_);
    try {
      run_samples();
      sample(true);
    } catch (const Error& error) {
      if (!options_.keep_failed || error.code() == ErrorCode::bad_input) throw;
      run_.failure = error;
      state_ = at_sample_;  // an engine may have left it anywhere
    }
    finish();
    return std::move(run_);
  }

 private:
  // From the first sample instant to the last.
  void run_samples() {
    const bool split = delay_.rest > 0;
    if (!clock_.jitters() && !options_.trace_step) {
      whole_segment_ = engine_->prepare(split ? delay_.period - delay_.rest : delay_.period);
      first_segment_ = split ? engine_->prepare(delay_.rest) : -1;
    }
    for (; k_ < steps_ && !run_.stopped_early; ++k_) {
      sample();
      if (options_.keep_failed) at_sample_ = state_;
      if (clock_.jitters() || options_.trace_step) {
        advance_by_events();
      } else {
        advance_by_segments();
      }
      if (k_ % samples_between_checks == 0) check_size();
      if (options_.on_progress && k_ % samples_between_reports == 0 && k_ > 0)
        options_.on_progress(samples_between_reports);
      clock_.advance();
    }
  }

  // Everything of sample instant k, before anything moves; after the last, nothing does.
  void sample(bool last = false) {
    const double t = clock_.time_of_tick(k_);
    row_.time = t;
    row_.measured = sensor_.read(plant_.sensor_position.state.dot(state_.xi));
    row_.command = controller_.step(row_.measured);
    const bool usable = std::isfinite(row_.command);
    if (usable) path_.send(k_, clock_.offset(), options_.dac.convert(row_.command));
    if (gesture_ && !last) {
      const double mean = gesture_->mean_effort(t, clock_.time_of_next(k_), clock_.period());
      hold({u_(0), options_.external_effort + mean});
    }
    // An effort that sets in late is no runaway: what it moves in a period counts as a start.
    const double pushed = pushing_ * std::abs(u_(1)) * clock_.period();
    reference_size_ = std::max(reference_size_, pushed);
    if (options_.record && (k_ % options_.record_every == 0 || last || !usable)) {
      sample_rows_.push_back(run_.trace.columns.front().size());
      record(t, path_.is_due(k_, clock_.offset()) ? path_.next_value() : u_(0));
    }
    if (usable) return;
    if (options_.keep_failed) at_sample_ = state_;
    throw Error(ErrorCode::numerical, fmt::format("t = {:g} s", t),
                fmt::format("step {} of the controller's law gives a command of {} from {:g}: its "
                            "numbers have grown out of all proportion",
                            k_, row_.command, row_.measured));
  }

  // With an even clock, every period is the same one or two segments.
  void advance_by_segments() {
    const double t = row_.time;
    const bool arrives = !path_.empty() && path_.next_after_tick(k_) < sampling_.period;
    if (first_segment_ >= 0) engine_->advance(first_segment_, t, u_, state_);
    if (arrives) hold({path_.receive(), u_(1)});
    engine_->advance(whole_segment_, t + (first_segment_ >= 0 ? delay_.rest : 0), u_, state_);
  }

  // From event to event: commands that take effect, and rows of the trace in between.
  void advance_by_events() {
    const Rational start = clock_.offset();  // all counted from k T on
    const Rational end = sampling_.period + clock_.next_offset();
    const Rational tick = sampling_.period * Rational(k_);
    std::int64_t grid =
        options_.trace_step ? floor_divide(tick + start, *options_.trace_step) + 1 : 0;
    Rational now = start;
    while (path_.is_due(k_, now)) hold({path_.receive(), u_(1)});
    while (now < end) {
      Rational stop = end;
      if (!path_.empty()) stop = std::min(stop, path_.next_after_tick(k_));
      if (options_.trace_step) stop = std::min(stop, Rational(grid) * *options_.trace_step - tick);
      move(now, stop - now);
      now = stop;
      if (now == end) break;
      const double t = (tick + now).to_double();
      if (path_.is_due(k_, now)) {
        if (options_.trace_step) record(t, path_.next_value());
        hold({path_.receive(), u_(1)});
      }
      if (!options_.trace_step) continue;
      record(t, u_(0));
      if (Rational(grid) * *options_.trace_step - tick == now) ++grid;
    }
  }

  void move(const Rational& from, const Rational& length) {
    const double t = row_.time + (from - clock_.offset()).to_double();
    if (clock_.jitters()) {
      engine_->advance_once(length.to_double(), t, u_, state_);
    } else {
      engine_->advance(engine_->prepare(length.to_double()), t, u_, state_);
    }
  }

  // Holds other inputs from now on.
  void hold(const Eigen::Vector2d& u) {
    if (u == u_) return;
    if (jumps_cost_energy_) {
      before_ = engine_->inputs(u_, state_);
      jump_ << state_.xi, before_, engine_->inputs(u, state_);
      state_.source_work += jump_.dot(plant_.energy.source_jump * jump_);
    }
    u_ = u;
  }

  void record(double time, double held_after) {
    if (!options_.record) return;
    recorder_.record({time, row_.measured, row_.command, held_after}, u_, state_);
  }

  void check_trace_size() {
    if (!options_.record) return;
    const double step = options_.trace_step
                            ? std::min(options_.trace_step->to_double(), delay_.period)
                            : delay_.period;
    const double rows = delay_.period * static_cast<double>(steps_) / step /
                        static_cast<double>(options_.record_every);
    const double bytes = rows * recorder_.row_size();
    if (bytes > most_trace_bytes) {
      throw Error(
          ErrorCode::bad_input, "simulation/duration",
          fmt::format("{:g} s: the trace would have {:.3g} rows and take {:.3g} GB of memory: at "
                      "most {:g} GB; shorten the duration or lengthen the trace step",
                      options_.duration.to_double(), rows, bytes * 1e-9, most_trace_bytes * 1e-9));
    }
    if (!options_.trace_step) recorder_.reserve(static_cast<std::size_t>(steps_) + 1);
  }

  void check_size() {
    throw_if_interrupted(fmt::format("t = {:g} s", row_.time));
    const Eigen::Index temperatures =
        plant_.nonlinear ? static_cast<Eigen::Index>(plant_.nonlinear->thermal.size()) : 0;
    const double size = state_.xi.head(plant_.states() - temperatures).cwiseAbs().maxCoeff();
    if (k_ <= samples_between_checks) reference_size_ = std::max(reference_size_, size);
    if (!std::isfinite(size) || (reference_size_ > 0 && size > runaway_ratio * reference_size_)) {
      run_.stopped_early = true;
    }
  }

  void finish() {
    run_.steps = k_;
    run_.engine = options_.engine;
    run_.events = state_.events;
    run_.final_time_s = row_.time;
    auto& e = run_.energy;
    e.operator_work = state_.operator_work;
    e.source = state_.source_work;
    e.dissipated = state_.dissipated;
    e.stored = recorder_.stored(u_, state_);
    e.residual = e.operator_work + e.source - (e.stored - e.stored_initially) - e.dissipated;
    if (options_.record && !run_.failure) classify_run();
  }

  // Rows in between do not count: the classification is the same with and without a trace step.
  void classify_run() {
    std::vector<double> position;
    std::vector<double> velocity;
    for (const std::size_t row : sample_rows_) {
      position.push_back(run_.trace.column("position")[row]);
      velocity.push_back(run_.trace.column("velocity")[row]);
    }
    run_.classification =
        classify(position, velocity, delay_.period * static_cast<double>(options_.record_every),
                 run_.stopped_early, options_.classification);
  }

  const Plant& plant_;
  Sampling sampling_;
  const SimulationOptions& options_;
  SplitDelay delay_;
  std::unique_ptr<Engine> engine_;
  RunningSensor sensor_;
  RunningController controller_;
  SampleClock clock_;
  CommandPath path_;
  std::optional<RunningGesture> gesture_;
  Eigen::Vector2d u_;  // held: command, external effort
  std::int64_t steps_, k_ = 0;
  PlantState state_, at_sample_;
  TimeRun run_;
  TraceRecorder recorder_;
  TraceRow row_;  // of the last sample instant
  std::vector<std::size_t> sample_rows_;
  int whole_segment_ = -1, first_segment_ = -1;
  bool jumps_cost_energy_ = false;
  double reference_size_ = 0;
  double pushing_ = 0;  ///< largest rate of a state per external effort
  Eigen::VectorXd jump_, before_;
};

}  // namespace

TimeRun simulate(const Plant& plant, const Sensor& sensor, const Controller& controller,
                 const Sampling& sampling, const SimulationOptions& options) {
  return Run(plant, sensor, controller, sampling, options).go();
}

}  // namespace gyrator

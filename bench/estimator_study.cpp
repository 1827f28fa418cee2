// What each velocity estimator is worth: the tables and the picture of docs/velocity-estimators.md.
//
//   estimator_study [PICTURE.svg]
#include "gyrator/controllers/velocity_response.hpp"
#include "gyrator/plots/plot.hpp"

#include <algorithm>

#include <fmt/core.h>

#include "../tests/support/estimator_errors.hpp"

namespace {

using namespace gyrator;
using namespace gyrator::estimator_errors;

void print_errors() {
  fmt::print("| estimator | delay at DC | noise gain |");
  for (const Motion& motion : make_motions()) fmt::print(" {} |", motion.name);
  fmt::print("\n| --- | --- | --- | --- | --- | --- |\n");
  for (const auto& [name, estimator] : make_estimators()) {
    fmt::print("| {} |", name);
    if (find_velocity_law(estimator, period)) {
      fmt::print(" {:.2f} ms | {:.1f} s⁻¹ |", 1e3 * compute_velocity_delay(estimator, period),
                 compute_velocity_noise_gain(estimator, period));
    } else {
      fmt::print(" – | – |");
    }
    for (const Motion& motion : make_motions())
      fmt::print(" {:.4f} |", measure_error(estimator, motion));
    fmt::print("\n");
  }
}

struct Line {
  const char* title;
  VelocityEstimator estimator;
  Colour colour;
};

std::vector<Line> make_linear_lines() {
  return {{"difference", DifferenceEstimator{1}, Colour::grey},
          {"difference, 10 samples", DifferenceEstimator{10}, Colour::black},
          {"filtered difference, 50 Hz", FilteredDifferenceEstimator{50}, Colour::blue},
          {"Butterworth 2, 50 Hz", ButterworthEstimator{2, 50}, Colour::vermillion},
          {"Butterworth 4, 50 Hz", ButterworthEstimator{4, 50}, Colour::green}};
}

std::vector<Panel> make_response_panels() {
  Panel gain{"Gain against an ideal differentiator",
             {"frequency", "Hz", true, 1, 500},
             {"|V/jω|", "", true, 1e-3, 2}};
  // Up to where the difference over ten samples changes its sign.
  Panel delay{"Delay", {"frequency", "Hz", true, 1, 100}, {"phase delay", "ms", false, 0, 12}};
  std::vector<double> frequency_hz;
  for (int i = 0; i <= 160; ++i) frequency_hz.push_back(std::pow(500.0, i / 160.0));
  for (const Line& line : make_linear_lines()) {
    Curve size{line.title, {}, {}, CurveStyle::line, line.colour};
    Curve late{"", {}, {}, CurveStyle::line, line.colour};
    for (const auto& r : compute_velocity_response(line.estimator, period, frequency_hz)) {
      size.x.push_back(r.frequency_hz);
      size.y.push_back(std::abs(r.ratio));
      if (r.frequency_hz >= 99) continue;
      // Half a turn late and more reads as early: no estimator is.
      const double delay_s = r.delay_s < 0 ? r.delay_s + 1 / r.frequency_hz : r.delay_s;
      late.x.push_back(r.frequency_hz);
      late.y.push_back(1e3 * delay_s);
    }
    gain.curves.push_back(size);
    delay.curves.push_back(late);
  }
  return {gain, delay};
}

// As fig. 8.9: the longer the window the less noise, and the more a motion is blurred.
Panel make_window_panel() {
  Panel panel{"Error over the (longest) window, swing of 0.2 rad at 2 Hz",
              {"window", "samples", true, 1, 100},
              {"rms error", "rad/s", true}};
  Curve fixed{"difference", {}, {}, CurveStyle::line, Colour::grey};
  Curve end{"FOAW, end fit", {}, {}, CurveStyle::line, Colour::vermillion};
  Curve best{"FOAW, best fit", {}, {}, CurveStyle::line, Colour::blue};
  const Motion swing = make_motions().back();
  for (int n = 1; n <= 100; n += std::max(1, n / 10)) {
    for (Curve* curve : {&fixed, &end, &best}) curve->x.push_back(n);
    fixed.y.push_back(measure_error(DifferenceEstimator{n}, swing));
    end.y.push_back(measure_error(AdaptiveWindowEstimator{quantum, n, WindowFit::end}, swing));
    best.y.push_back(measure_error(AdaptiveWindowEstimator{quantum, n, WindowFit::best}, swing));
  }
  panel.curves = {fixed, end, best};
  return panel;
}

// A motion that is stopped by a wall.
Panel make_stop_panel() {
  Panel panel{"0.4 rad/s, stopped at once", {"time", "ms"}, {"velocity", "rad/s"}};
  const std::vector<Line> lines = {
      {"difference", DifferenceEstimator{1}, Colour::grey},
      {"Butterworth 2, 50 Hz", ButterworthEstimator{2, 50}, Colour::vermillion},
      {"FOAW to 32, best fit", AdaptiveWindowEstimator{quantum, 32, WindowFit::best}, Colour::blue},
      {"Levant, 40 rad/s²", LevantEstimator{40}, Colour::green}};
  for (const Line& line : lines) {
    Curve curve{line.title, {}, {}, CurveStyle::steps, line.colour};
    RunningVelocityEstimator run(line.estimator, period);
    for (int k = -500; k <= 40; ++k) {
      const double v = run.step(sense(0.4 * period * std::min(k, 0)));
      if (k < -20) continue;
      curve.x.push_back(1e3 * k * period);
      curve.y.push_back(v);
    }
    panel.curves.push_back(curve);
  }
  return panel;
}

}  // namespace

int main(int argc, char** argv) {
  print_errors();
  if (argc < 2) return 0;
  Figure figure{"Velocity estimators at 1 kHz", make_response_panels(), 2};
  figure.panels.push_back(make_window_panel());
  figure.panels.push_back(make_stop_panel());
  render_figure(figure, argv[1]);
  return 0;
}

#include "gyrator/controllers/passivity_control.hpp"

#include "gyrator/controllers/controller.hpp"
#include "gyrator/controllers/linear_motion.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "support/law_list.hpp"

namespace gyrator {
namespace {

using testing::make_controller_list;
using testing::NamedController;

constexpr double T = 1e-3;
constexpr double mass = 0.5, damping = 2;  // of the device
constexpr auto simple = PassivityControl::Observer::simple;
constexpr auto reference = PassivityControl::Observer::reference;

// A damper of m/T stops the device in one sample.
PassivityControl limited(PassivityControl::Observer observer) {
  return {.observer = observer, .max_damping = mass / T};
}

// Without a control of their own.
std::vector<NamedController> controllers_that_can_be_wrapped() {
  std::vector<NamedController> list;
  for (NamedController& named : make_controller_list()) {
    const auto& around = named.controller.wrappers;
    const bool controlled = std::any_of(around.begin(), around.end(), [](const Wrapper& wrapper) {
      return std::holds_alternative<PassivityControl>(wrapper);
    });
    if (reads_position(named.controller.law) && !controlled) list.push_back(std::move(named));
  }
  return list;
}

// A smooth gesture that comes and goes through the surface: ten random sines up to 40 Hz.
class Gesture {
 public:
  explicit Gesture(unsigned seed) : random_(seed) {
    for (Sine& s : sines_) s = {between(0.2, 2e-3 * 2), between(1, 40), between(0, 6.283)};
    for (Sine& s : sines_) s.amplitude *= 1e-3 / 0.2;
  }
  double at(double t) const {
    double x = 0;
    for (const Sine& s : sines_) x += s.amplitude * std::sin(6.283 * s.frequency * t + s.phase);
    return x;
  }

 private:
  struct Sine {
    double amplitude, frequency, phase;
  };
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  std::mt19937 random_;
  std::vector<Sine> sines_ = std::vector<Sine>(10);
};

// S + D of the law in continuous time: a wall's spring and damper, else trapezoids of f_2.
class Reference {
 public:
  explicit Reference(const Law& law) {
    if (const auto* wall = std::get_if<VirtualWall>(&law)) {
      wall_ = {wall->stiffness, std::max(wall->damping, 0.0), wall->unilateral, wall->no_pull};
    } else if (const auto* predictive = std::get_if<PredictiveWall>(&law)) {
      wall_ = {predictive->stiffness, predictive->damping, predictive->unilateral};
    } else {
      is_wall_ = false;
    }
  }

  void start(double y, double wanted) {
    wanted_ = wanted;
    if (is_wall_) spring_ = start_ = stored_at(y);
  }
  // After the motion to y by `moved`, with f_2 there.
  void follow(double y, double moved, double wanted) {
    if (!is_wall_) {
      dissipated_ += (wanted_ + wanted) / 2 * moved;
      wanted_ = wanted;
      return;
    }
    const double v = moved / T;
    const bool inside = !wall_.unilateral || y > 0;
    const bool relaxes = inside && wall_.no_pull && wall_.stiffness * y + wall_.damping * v < 0;
    const double spring = stored_at(y);
    if (relaxes) {
      dissipated_ += spring_ - spring;  // into its own damper: S + D stays
    } else if (inside) {
      dissipated_ += wall_.damping * v * moved;
    }
    spring_ = spring;
  }
  // What the port may have given at most, as a bound from below on E.
  double owed() const { return std::max(spring_ + dissipated_, 0.0) - start_; }

 private:
  double stored_at(double y) const {
    const double x = wall_.unilateral ? std::max(y, 0.0) : y;
    return wall_.stiffness * x * x / 2;
  }
  ReferenceWall wall_;
  bool is_wall_ = true;
  double spring_ = 0, dissipated_ = 0, start_ = 0, wanted_ = 0;
};

// Keeps the books of (pc-1) outside the control, and finds from f_2, by (pc-2) to (pc-5), what the
// control has to make good; from that, what (pc-6) and (pc-7) allow after the next step.
class Books {
 public:
  Books(const Law& law, const PassivityControl& control) : control_(control), reference_(law) {}

  // Before the command at y: the energy that came in, and the least that is allowed.
  void arrive(double y) {
    const double step = started_ ? y - last_ : 0;
    energy_ += effort_ * step;
    size_ += std::abs(effort_ * step);
    if (started_) {
      allowed_ =
          control_.observer == simple
              ? std::min(0.0, left_) - std::abs(effort_) * std::abs(step - moved_)
              : left_ + wanted_ * step - std::abs(effort_ - wanted_) * std::abs(step - moved_);
    }
    moved_ = step;
    last_ = y;
  }
  // After it, with f_2 and f_1.
  void leave(double wanted, double commanded) {
    if (!started_) reference_.start(last_, wanted);
    reference_.follow(last_, moved_, wanted);
    started_ = true;
    wanted_ = wanted;
    effort_ = commanded;
    const double before = energy_ + (control_.observer == simple ? wanted * moved_ : 0);
    const double goal = control_.observer == simple ? 0 : reference_.owed();
    left_ = before + std::min(std::max(goal - before, 0.0), most_made_good());
  }

  double energy() const { return energy_; }
  double allowed() const { return allowed_; }
  // Sums of numbers as large as these are rounded.
  double rounding() const { return 1e-12 * (1e-3 + size_ + std::abs(allowed_)); }

 private:
  double most_made_good() const {
    if (moved_ == 0) return 0;
    double limit = INFINITY;
    if (control_.max_damping) limit = *control_.max_damping * std::abs(moved_) / T;
    if (control_.max_effort) limit = std::min(limit, *control_.max_effort);
    return limit * std::abs(moved_);
  }

  PassivityControl control_;
  Reference reference_;
  double energy_ = 0, size_ = 0, effort_ = 0, wanted_ = 0, last_ = 0, moved_ = 0;
  double left_ = 0, allowed_ = 0;
  bool started_ = false;
};

// Runs a motion that may depend on the command through the controller and its control.
void expect_energy_as_the_law_allows(const NamedController& named, const PassivityControl& control,
                                     const std::function<double(int, double)>& motion) {
  Controller controlled = named.controller;
  controlled.wrappers.emplace_back(control);
  RunningController running(controlled, T);
  Books books(named.controller.law, control);
  // The outermost wrapper tells last: observed energy and f_pc.
  std::vector<double> signals(running.signal_names().size());
  const double& observed = signals[signals.size() - 2];
  const double& added = signals.back();
  double command = 0;
  for (int k = 0; k < 4000; ++k) {
    const double y = motion(k, command);
    books.arrive(y);
    command = running.step(y);
    running.read_signals(signals);
    ASSERT_TRUE(std::isfinite(command)) << named.name << " sample " << k;
    ASSERT_NEAR(observed, books.energy(), books.rounding()) << named.name << " sample " << k;
    ASSERT_GE(books.energy(), books.allowed() - books.rounding()) << named.name << " sample " << k;
    books.leave(-command - added, -command);
  }
}

TEST(PassivityControl, keeps_the_energy_of_every_law_where_its_own_law_says_in_any_gesture) {
  for (const NamedController& named : controllers_that_can_be_wrapped()) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Gesture gesture(seed);
      const auto motion = [&](int k, double /*command*/) {
        return gesture.at(k * T) - gesture.at(0);
      };
      for (const auto observer : {simple, reference}) {
        expect_energy_as_the_law_allows(named, {.observer = observer}, motion);
        expect_energy_as_the_law_allows(named, {.observer = observer, .max_effort = 5}, motion);
        expect_energy_as_the_law_allows(named, limited(observer), motion);
      }
    }
  }
}

// A device in a random hand: pushes that change every 50 ms.
class Device {
 public:
  explicit Device(unsigned seed, double push = 20) : random_(seed), push_(push) {}

  double operator()(int k, double command) {
    if (k == 0) return state_.position;
    if (k % 50 == 1) hand_ = std::uniform_real_distribution<double>(-push_, push_)(random_);
    state_ = LinearMotion(mass, damping, 0, command + hand_).after(state_, T);
    return state_.position;
  }
  const MotionState& state() const { return state_; }

 private:
  std::mt19937 random_;
  double push_, hand_ = 0;
  MotionState state_{-1e-3, 0};
};

TEST(PassivityControl, keeps_the_energy_of_every_law_with_a_device_in_a_random_hand) {
  for (const NamedController& named : controllers_that_can_be_wrapped()) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      for (const auto observer : {simple, reference}) {
        Device device(seed);
        expect_energy_as_the_law_allows(named, limited(observer), std::ref(device));
      }
    }
  }
}

// Largest excursion in each of `parts` equal parts of a run of a device pressed into a law by 5 N.
std::vector<double> press(const std::function<double(double)>& law, double inertia, int parts) {
  MotionState s{0, 0.1};
  std::vector<double> spread;
  for (int part = 0; part < parts; ++part) {
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 1000; ++k) {
      s = LinearMotion(inertia, damping, 0, 5 + law(s.position)).after(s, T);
      low = std::min(low, s.position);
      high = std::max(high, s.position);
    }
    spread.push_back(high - low);
  }
  return spread;
}

TEST(PassivityControl, follows_the_energy_of_a_spring_to_the_last_joule) {
  // One push into a spring and out again, slow enough that 1/2 K dx^2 a sample is all that leaks:
  // W of (pc-3) never falls below the leak of one step and the part of f_pc that missed.
  const double K = 2e4;
  RunningPassivityControl control({.observer = reference, .max_damping = 500},
                                  ReferenceWall{.stiffness = K, .unilateral = true}, T);
  double last = 0, moved = 0;
  for (int k = 0; k <= 1000; ++k) {
    const double y = 5e-3 * std::sin(3.14159265 * k * T);
    const double step = y - last;
    const double added = control.effort();
    control.step(y, -K * std::max(y, 0.0));
    const double shortfall = control.observed_energy() - K * y * y / 2;
    EXPECT_GE(shortfall, -K * step * step / 2 - std::abs(added) * std::abs(step - moved) - 1e-15)
        << k;
    last = y;
    moved = step;
  }
  // Without it the spring gives sum K dx^2/2 too much: 2.5 mm rms a second in steps of dx.
  EXPECT_GE(control.observed_energy(), -K * std::pow(5e-3 * 3.14159265 * T, 2));
}

TEST(PassivityControl, does_nothing_to_what_is_passive) {
  // A damper in steady motion takes in energy at every step. The very first force comes a sample
  // after the motion: the reference makes that up once.
  const VirtualWall damper{.stiffness = 0, .damping = 30};
  for (const auto observer : {simple, reference}) {
    RunningController wrapped(Controller(damper, {PassivityControl{observer}}), T);
    RunningController bare(damper, T);
    for (int k = 0; k < 100; ++k) {
      const double y = 1e-4 * k;
      const double once = observer == reference && k == 1 ? 3 : 0;
      EXPECT_NEAR(wrapped.step(y), bare.step(y) - once, 1e-11) << k;
    }
  }
}

TEST(PassivityControl, acts_at_once_where_the_simple_observer_has_to_spend_first) {
  // Honey on one side, a hard spring on the other. The hand stirs the honey for a second, then the
  // device is let go against the spring.
  const auto run = [](PassivityControl::Observer observer) {
    RunningPassivityControl control(limited(observer), std::nullopt, T);
    double last = 0;
    const auto law = [&](double y) {
      const double effort = y > 0 ? 60e3 * y : 40 * (y - last) / T;
      last = y;
      return control.step(y, -effort);
    };
    for (int k = 0; k <= 1000; ++k) law(-0.02 * (1 - std::cos(6.283185307 * 5 * k * T)));
    const double saved = control.observed_energy();
    MotionState s{0, 0};
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 2000; ++k) {  // pressed against the spring by 30 N
      s = LinearMotion(mass, 0, 0, 30 + law(s.position)).after(s, T);
      if (k < 1500) continue;
      low = std::min(low, s.position);
      high = std::max(high, s.position);
    }
    return std::pair(saved, high - low);
  };
  const auto [saved_simple, shaking_simple] = run(simple);
  const auto [saved_reference, shaking_reference] = run(reference);
  EXPECT_GT(saved_simple, 5.0);
  EXPECT_GT(saved_reference, 5.0);
  // On a lossless spring the device swings by 2 F/K = 1 mm for ever; what the hold adds and the
  // control has not made good yet is K (v T)^2/2 with v = F/sqrt(K m), a sixteenth of F^2/2K.
  EXPECT_GT(shaking_simple, 2e-3);
  EXPECT_LT(shaking_reference, 1e-3 * (1 + 1.0 / 16));
}

TEST(PassivityControl, published_cases_oscillate_without_and_settle_with_it) {
  // 90 kN/m at 1 kHz, and 30 kN/m computed every 15 samples (Hannaford and Ryu 2002). The paper
  // gives no mass of the device; 2 kg and 0.5 kg are chosen.
  for (const double inertia : {2.0, 0.5}) {
    for (const auto& [stiffness, hold] : {std::pair(90e3, 1), std::pair(30e3, 15)}) {
      const auto make_wall = [K = stiffness, every = hold] {
        return [K, every, k = 0, effort = 0.0](double y) mutable {
          if (k++ % every == 0) effort = K * std::max(y, 0.0);
          return -effort;
        };
      };
      const auto bare = press(make_wall(), inertia, 8);
      EXPECT_GE(bare.back(), 0.5 * bare.front()) << "without control it goes on";
      for (const auto observer : {simple, reference}) {
        RunningPassivityControl control({observer, inertia / T}, ReferenceWall{stiffness, 0, true},
                                        T);
        const auto settling =
            press([&, wall = make_wall()](double y) mutable { return control.step(y, wall(y)); },
                  inertia, 8);
        EXPECT_LT(settling.back(), 0.06 * settling.front()) << stiffness << " " << inertia;
        EXPECT_LT(settling.back(), 0.02 * bare.back()) << stiffness << " " << inertia;
      }
    }
  }
}

TEST(PassivityControl, knows_that_a_wall_without_pull_keeps_what_it_does_not_give_back) {
  // In at 2, 1 and 1 m/s, rest, and out so fast that K y + B v < 0: such a wall lets go, its spring
  // relaxes against its own damper. S + D stays 50 (2 x 2 + 1 + 1) mJ + 1000/2 x 9e-6 J.
  RunningPassivityControl control(
      {reference},
      ReferenceWall{.stiffness = 1000, .damping = 50, .unilateral = true, .no_pull = true}, T);
  for (const double y : {-1e-3, 1e-3, 2e-3, 3e-3, 3e-3, 2e-3, 1e-3, -1e-3}) control.step(y, 0);
  EXPECT_NEAR(control.effort() * -2e-3, 0.3 + 4.5e-3 - control.observed_energy(), 1e-12);
}

TEST(PassivityControl, refuses_limits_that_are_not_positive) {
  EXPECT_THROW(RunningPassivityControl({.max_damping = 0}, std::nullopt, T), Error);
  EXPECT_THROW(RunningPassivityControl({.max_effort = -1}, std::nullopt, T), Error);
}

}  // namespace
}  // namespace gyrator

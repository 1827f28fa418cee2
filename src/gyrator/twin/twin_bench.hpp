#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/twin/simulated_amplifier.hpp"

namespace gyrator {

/// Experiments on a simulated amplifier in this process, without a link: what the Modbus bench does
/// with registers, done with calls. Nothing of the device's truth is handed on.
class TwinBench : public Bench {
 public:
  /// `amplifier` must outlive this.
  explicit TwinBench(SimulatedAmplifier& amplifier) : amplifier_(amplifier) {}

  BenchLimits limits() const override;
  /// The drive stays on until excitation and capture are both over.
  Capture run(const Excitation& excitation, const CaptureRequest& request) override;
  std::optional<double> winding_temperature() override;
  void wait(double seconds) override { amplifier_.advance(seconds); }
  bool has_setting(std::string_view name) const override;
  SettingRange setting_range(std::string_view name) const override;
  double read_setting(std::string_view name) override { return amplifier_.read(name); }
  void write_setting(std::string_view name, double value) override {
    amplifier_.write(name, value);
  }

 private:
  void check(const Excitation& excitation, const CaptureRequest& request) const;

  SimulatedAmplifier& amplifier_;
};

}  // namespace gyrator

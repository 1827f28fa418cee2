#pragma once

#include "gyrator/studies/model_file.hpp"
#include "gyrator/two_port/coupled_devices.hpp"
#include "gyrator/two_port/rendering_port.hpp"

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// A logarithmic sweep [Hz]: up to the Nyquist frequency of what is computed, from a thousandth of
/// it, where nothing else is asked for.
struct TwoPortSweep {
  std::optional<double> from_hz, to_hz;
  int points = 200;
};

struct TwoPortRequest {
  std::vector<std::string> renderings;  ///< by name; empty: the controller's own
  Sensing sensing = Sensing::velocity;
  double passivity_damping = 0;  ///< C_pc [N.s/m, N.m.s/rad]
  TwoPortSweep sweep;
};

/// Hybrid matrix, conditions, transmitted impedance and stiffest coupling of a model's environment
/// (`gyrator twoport MODEL`). The keys on top are those of the first rendering. Throws bad_input
/// for a controller without one, a rendering that is unknown or whose values the controller has
/// not, and a sweep beyond Nyquist; numerical for a device that is unstable alone.
nlohmann::json make_two_port_result(const Model& model, const TwoPortRequest& request);

struct RemoteRequest {
  SpringDamper coupling;   ///< [N/m, N.s/m; N.m/rad, N.m.s/rad]
  double delay_there = 0;  ///< from master to slave [s]
  double delay_back = 0;   ///< [s]
  CouplingPlace place = CouplingPlace::both_ends;
  Sensing sensing = Sensing::velocity;
  TwoPortSweep sweep;
};

/// The same of two devices joined by a coupling (`gyrator twoport MASTER --remote SLAVE`); both
/// models' controllers are left out. The environment is the slave's operator: what the master's
/// hand feels is given for it. Throws bad_input for different motions or sampling periods.
nlohmann::json make_remote_result(const Model& master, const Model& slave,
                                  const RemoteRequest& request);

}  // namespace gyrator

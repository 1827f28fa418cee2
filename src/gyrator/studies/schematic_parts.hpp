#pragma once

#include "gyrator/core/quantity.hpp"
#include "gyrator/plots/schematic_symbols.hpp"
#include "gyrator/studies/model_file.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

// A model as what is drawn of it, without any coordinates. schematic_parts.cpp has one function per
// kind of damping, amplifier, controller, estimator and operator; schematic.cpp places the parts.

/// One symbol with its label.
struct Part {
  Symbol symbol = Symbol::box;
  std::string what;                 ///< in words: "winding resistance"
  std::string name;                 ///< "R_m"
  std::vector<std::string> values;  ///< "1.5 Ω"; one line each
  std::string letter = {};          ///< inside a meter
};

/// Parts in a row from the upper to the lower rail. Behind a mass nothing follows; a branch without
/// parts is a rigid link.
using Branch = std::vector<Part>;

/// Lines of text in a block of the signal path.
using BlockText = std::vector<std::string>;

/// Where a feedback begins.
enum class Tap {
  motor_current,
  back_emf,  ///< motor current and winding voltage
  position,
  effort  ///< the meter in one of the branches at the port
};

/// A signal from a tap through blocks into the command.
struct Feedback {
  Tap tap = Tap::motor_current;
  std::vector<BlockText> blocks;  ///< in the order of the signal
  char sign = '-';
  std::size_t branch = 0;        ///< of Tap::effort: which at the port
  bool set_by_computer = false;  ///< the last block's gains come from the controller
};

/// In series with the motor; `feedback` is the block from the motor's current to the source.
struct SeriesPart {
  Part part;
  BlockText feedback;
};

struct MotorParts {
  std::vector<Part> winding;
  BlockText gyrator;  ///< lines in it
  std::string what;   ///< "rotary motor"
};

/// What the computer samples. Nothing: it only sets the gains of an analog loop.
enum class Sampled { position, terminal_voltage, nothing };

/// The sampled side, from sampler to command.
struct ComputerParts {
  Sampled sampled = Sampled::position;
  std::string period;
  std::vector<BlockText> blocks;  ///< in the order of the signal
};

struct Diagram {
  std::string title;
  std::vector<BlockText> amplifier_loop;  ///< between command and amplifier
  Part amplifier;
  bool amplifier_at_shaft = false;
  std::vector<Part> amplifier_output;  ///< in series behind it
  std::vector<Branch> across;          ///< across the motor terminals
  std::vector<SeriesPart> in_series;   ///< between terminals and winding
  std::optional<MotorParts> motor;
  std::vector<Branch> at_shaft;
  std::vector<Part> transmission;  ///< side by side, from shaft to port
  std::vector<Branch> at_load;     ///< behind the transmission, before sensor and dampers
  std::vector<Branch> at_port;     ///< dampers
  bool sensor_at_shaft = false;    ///< else at the port
  BlockText sensor;
  ComputerParts computer;
  std::vector<Branch> held_by;
  std::string operator_kind;  ///< "free"
  std::vector<Feedback> feedback;
};

Diagram describe_device(const Model& model);

/// Every part with its values in a sentence, for who cannot see the picture.
std::string describe_in_words(const Diagram& diagram);

/// "2.2 mF" as one prints it: the unit's own signs, Ω and µ, and powers of ten.
std::string print_quantity(double value, const Unit& unit);

}  // namespace gyrator

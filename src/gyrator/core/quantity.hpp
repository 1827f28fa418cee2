#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace gyrator {

/// Exponents of the SI base units, of the angle and of encoder counts.
///
/// The angle is carried so that "rad/s" and "Hz" stay apart, and is ignored where it distinguishes
/// nothing: N.m.s and N.m.s/rad are both a rotary damping.
struct Dimension {
  int length = 0;       ///< m
  int mass = 0;         ///< kg
  int time = 0;         ///< s
  int current = 0;      ///< A
  int temperature = 0;  ///< K
  int angle = 0;        ///< rad
  int count = 0;        ///< increments of an encoder

  friend constexpr bool operator==(const Dimension&, const Dimension&) = default;
};

/// A value in SI units [m kg s A K rad] with the dimension that its text gave.
struct Quantity {
  double value = 0;
  std::optional<Dimension> dimension;  ///< nothing for a bare number, which fits every unit
  std::string text;                    ///< as written, for messages
};

/// Reads a number with a unit: "4.7 kohm", "50 mN.m/A", "8192 counts/rev", "1/60 s", "0.001".
///
///   quantity = number [space] [unit]       number = decimal [ "/" decimal ]
///   unit     = [ "/" ] factor { ("." | "·" | "*" | "/") factor }          (no spaces inside)
///   factor   = symbol [ "^" integer | "²" | "³" ] | "1" | "(" unit ")" [ power ]
///
/// Each "/" divides by the next factor only: N.m/rad/s and N.m/(rad.s) are the same, N.m.s/rad is
/// a damping. Symbols: m g s A K N J W V ohm Ω F H Hz C rad deg ° rev rpm count min % ppm, with the
/// prefixes p n u µ m c k M G where SI allows one; a whole symbol goes before prefix and symbol, so
/// "m" is metre and "min" minute. Powers of ten are applied to the decimal text, so "2200 uF" is
/// the same double as 2200e-6.
/// Throws bad_input, without a place, for anything else; the message names the nearest unit.
Quantity parse_quantity(std::string_view text);

/// How the angle and the count of a given quantity are matched with the expected ones.
enum class Match {
  ignore_angle,  ///< N.m.s fits N.m.s/rad
  exact,         ///< the angle counts: rad/s is expected and Hz is ambiguous
  cycles,        ///< expected in Hz; with an angle (rad/s, rev/s, rpm) it is divided by 2π
  resolution     ///< a step; counts per angle or length are inverted: 8192 counts/rev
};

/// What a value must be: the dimension, and how to say so.
struct Unit {
  std::string_view name;  ///< "rotary damping"
  Dimension dimension;
  std::string_view symbol;   ///< the SI unit, "N.m.s/rad"; "1" for a pure number
  std::string_view example;  ///< "0.1 mN.m.s/rad"
  Match match = Match::ignore_angle;

  friend constexpr bool operator==(const Unit&, const Unit&) = default;
};

/// The units that the files of users are made of.
namespace dimension {

inline constexpr Unit none{"pure number", {}, "1", "5 %", Match::exact};
inline constexpr Unit time{"time", {.time = 1}, "s", "1 ms"};
inline constexpr Unit frequency{"frequency", {.time = -1}, "Hz", "1 kHz", Match::cycles};
inline constexpr Unit angle{"angle", {.angle = 1}, "rad", "30 deg", Match::exact};
inline constexpr Unit angular_velocity{
    "angular velocity", {.time = -1, .angle = 1}, "rad/s", "2 rad/s", Match::exact};
inline constexpr Unit angular_acceleration{
    "angular acceleration", {.time = -2, .angle = 1}, "rad/s^2", "100 rad/s^2", Match::exact};
inline constexpr Unit length{"length", {.length = 1}, "m", "5 mm"};
inline constexpr Unit velocity{"velocity", {.length = 1, .time = -1}, "m/s", "0.2 m/s"};
inline constexpr Unit acceleration{"acceleration", {.length = 1, .time = -2}, "m/s^2", "3 m/s^2"};
inline constexpr Unit mass{"mass", {.mass = 1}, "kg", "60 g"};
inline constexpr Unit inertia{"inertia", {.length = 2, .mass = 1}, "kg.m^2", "2e-5 kg.m^2"};
inline constexpr Unit force{"force", {.length = 1, .mass = 1, .time = -2}, "N", "3 N"};
inline constexpr Unit torque{"torque", {.length = 2, .mass = 1, .time = -2}, "N.m", "50 mN.m"};
inline constexpr Unit linear_stiffness{
    "linear stiffness", {.mass = 1, .time = -2}, "N/m", "2 N/mm"};
inline constexpr Unit rotary_stiffness{"rotary stiffness",
                                       {.length = 2, .mass = 1, .time = -2, .angle = -1},
                                       "N.m/rad",
                                       "0.4 N.m/rad"};
inline constexpr Unit linear_damping{"linear damping", {.mass = 1, .time = -1}, "N.s/m", "2 N.s/m"};
inline constexpr Unit rotary_damping{"rotary damping",
                                     {.length = 2, .mass = 1, .time = -1, .angle = -1},
                                     "N.m.s/rad",
                                     "0.1 mN.m.s/rad"};
inline constexpr Unit torque_constant{
    "torque constant", {.length = 2, .mass = 1, .time = -2, .current = -1}, "N.m/A", "50 mN.m/A"};
inline constexpr Unit force_constant{
    "force constant", {.length = 1, .mass = 1, .time = -2, .current = -1}, "N/A", "8 N/A"};
inline constexpr Unit resistance{
    "resistance", {.length = 2, .mass = 1, .time = -3, .current = -2}, "ohm", "1.5 ohm"};
inline constexpr Unit inductance{
    "inductance", {.length = 2, .mass = 1, .time = -2, .current = -2}, "H", "0.5 mH"};
inline constexpr Unit capacitance{
    "capacitance", {.length = -2, .mass = -1, .time = 4, .current = 2}, "F", "2200 uF"};
inline constexpr Unit voltage{
    "voltage", {.length = 2, .mass = 1, .time = -3, .current = -1}, "V", "24 V"};
inline constexpr Unit current{"current", {.current = 1}, "A", "800 mA"};
inline constexpr Unit power{"power", {.length = 2, .mass = 1, .time = -3}, "W", "10 W"};
inline constexpr Unit energy{"energy", {.length = 2, .mass = 1, .time = -2}, "J", "5 mJ"};
inline constexpr Unit temperature{"temperature", {.temperature = 1}, "K", "298 K"};
inline constexpr Unit temperature_coefficient{
    "temperature coefficient", {.temperature = -1}, "1/K", "0.39 %/K"};
inline constexpr Unit thermal_resistance{
    "thermal resistance", {.length = -2, .mass = -1, .time = 3, .temperature = 1}, "K/W", "5 K/W"};
inline constexpr Unit thermal_capacity{
    "thermal capacity", {.length = 2, .mass = 1, .time = -2, .temperature = -1}, "J/K", "20 J/K"};
inline constexpr Unit angle_quantum{
    "encoder step (angle)", {.angle = 1}, "rad", "8192 counts/rev", Match::resolution};
inline constexpr Unit length_quantum{
    "encoder step (length)", {.length = 1}, "m", "200 counts/mm", Match::resolution};

/// Every unit above; where two share a dimension, the one that names it in messages comes first.
inline constexpr std::array all{none,
                                time,
                                frequency,
                                angle,
                                angular_velocity,
                                angular_acceleration,
                                length,
                                velocity,
                                acceleration,
                                mass,
                                inertia,
                                force,
                                torque,
                                linear_stiffness,
                                rotary_stiffness,
                                linear_damping,
                                rotary_damping,
                                torque_constant,
                                force_constant,
                                resistance,
                                inductance,
                                capacitance,
                                voltage,
                                current,
                                power,
                                energy,
                                temperature,
                                temperature_coefficient,
                                thermal_resistance,
                                thermal_capacity,
                                angle_quantum,
                                length_quantum};

}  // namespace dimension

/// The value in the SI unit that is expected; a bare number is taken to be in it already.
/// Throws bad_input for another dimension: what was given, what it is, what is expected.
double value_in(const Quantity& given, const Unit& expected);

/// value_in(parse_quantity(text), expected), as a command line needs it.
double parse_value(std::string_view text, const Unit& expected);

/// "capacitance [F]" where the list above has a name for it, else base units: "A.s".
std::string describe_dimension(const Dimension& dimension);

/// A value for human eyes, six digits with an engineering prefix: "2.2 mF", "50 mN.m/A", "60 g".
std::string format_quantity(double value, const Unit& unit);

}  // namespace gyrator

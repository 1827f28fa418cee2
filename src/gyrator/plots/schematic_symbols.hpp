#pragma once

#include "gyrator/plots/svg_canvas.hpp"

namespace gyrator {

/// The symbols with two ends, drawn between any two points.
enum class Symbol {
  resistor,            ///< rectangle
  capacitor,           ///< two plates
  inductor,            ///< four arcs
  clamp,               ///< two diodes that face each other: conducts above a voltage
  current_source,      ///< circle with an arrow; of effort as well
  voltage_source,      ///< circle with + and -
  controlled_voltage,  ///< diamond with + and -
  meter,               ///< circle with a letter, in line
  spring,              ///< zigzag
  damper,              ///< dashpot
  brake,               ///< disk between the poles of a magnet
  friction,            ///< disk between shoes that touch
  mass,                ///< block on one wire
  box                  ///< anything with two ends, named inside
};

/// Half the length and half the width that a symbol takes, wires aside [px].
struct SymbolSize {
  double half_length = 0;
  double half_width = 0;
};
SymbolSize size_of(Symbol symbol);

/// The symbol midway between `a` and `b` with wires to both; a current flows, and a source drives
/// it, towards `a`, whose side is +. `letter` is for a meter; a mass has no wire to `b`.
void draw_symbol(SvgCanvas& canvas, Symbol symbol, Point a, Point b, Ink ink,
                 std::string_view letter = {});

/// Below a point: the electrical reference; what does not move.
void draw_ground(SvgCanvas& canvas, Point at);
void draw_fixed_frame(SvgCanvas& canvas, Point at);
/// Wires meet here; a wire ends here.
void draw_junction(SvgCanvas& canvas, Point at, Ink ink);
void draw_terminal(SvgCanvas& canvas, Point at, Ink ink);

/// A gyrator between its corners: two facing arcs at the middle of its upper part.
void draw_gyrator(SvgCanvas& canvas, Point top_left, Point bottom_right);

inline constexpr double sum_radius = 8;
/// A circle where signals are added.
void draw_sum(SvgCanvas& canvas, Point at);

/// A block of the signal path, with lines of text centred in it; the first may have a subscript.
void draw_block(SvgCanvas& canvas, Point centre, const std::vector<std::string>& lines);
/// Size of that block [px].
double block_width(const std::vector<std::string>& lines);
double block_height(const std::vector<std::string>& lines);

/// A switch that closes for an instant, open from `right` to `left`, 40 px apart.
void draw_sampler(SvgCanvas& canvas, Point right, Point left);

}  // namespace gyrator

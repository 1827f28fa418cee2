#pragma once

#include "gyrator/studies/schematic.hpp"
#include "gyrator/studies/schematic_parts.hpp"

#include <vector>

namespace gyrator {

/// Places a diagram's parts and draws them, once. Things are drawn from left to right, each where
/// the last one ended (x_); a tap stands far enough to the right for what hangs on its signal.
class SchematicLayout {
 public:
  explicit SchematicLayout(const Diagram& diagram) : d_(diagram) {}

  Schematic draw();

 private:
  // schematic.cpp: rows, branches, parts on a rail
  void place_rows();
  std::size_t most_parts() const;
  bool crosses_circuit() const;  // an effort source acts behind a motor: its command passes over it
  bool computer_sets_gains() const { return d_.computer.sampled == Sampled::nothing; }
  double draw_branch(const Branch& branch, Ink ink, double least_half_width = 0);
  void join_rail(double x, Ink ink, bool floats);
  double draw_on_rail(const Part& part, Ink ink, double room = 0);
  void draw_part(const Part& part, Point a, Point b, Ink ink);
  void draw_label_below(const Part& part, double x, double y);
  Schematic finish();

  // schematic_circuit.cpp: what carries power
  void draw_amplifier(Ink ink);
  void draw_electrical();
  void draw_series();
  void draw_series_part(const SeriesPart& series);
  void draw_motor();
  void draw_gyrator_box(double right);
  void draw_mechanical();
  void draw_transmission();
  void draw_operator();

  // schematic_signals.cpp: what carries none
  void draw_command();
  void draw_sensor();
  bool is_position_read() const;
  double end_of_lane(std::size_t k) const;  // how far right its tap must be
  void draw_lanes();
  double draw_estimator(const BlockText& lines, double y);
  std::vector<Point> start_of(const Feedback& f, double x, double y) const;
  void draw_lane(std::size_t k, const std::vector<BlockText>& blocks, std::vector<Point> line);
  double sampler_room() const;
  double computer_end() const;
  double draw_sampler_in(double right);
  void draw_computer();

  const Diagram& d_;
  SvgCanvas canvas_;
  double top_ = 0, bottom_ = 0, middle_ = 0;  // the rails, and half-way
  double command_y_ = 0, local_y_ = 0, computer_y_ = 0, gains_y_ = 0;
  std::vector<double> lane_y_, sum_x_;  // of each feedback
  double x_ = 0;                        // where the next thing begins
  double rail_from_ = -1;               // end of the upper rail so far; below 0: none yet
  double return_from_ = -1;             // beginning of the lower rail, likewise
  double riser_x_ = 0, command_end_ = 0;
  double terminal_x_ = 0, current_x_ = 0, voltage_x_ = 0, sensor_x_ = 0;  // taps
  std::vector<double> branch_x_;  // of each branch at the port
  Point gains_to_;
  double height_ = 0;
};

// Distances in pixels.
inline constexpr double layout_margin = 24;
inline constexpr double layout_gap = 16;  // between neighbours
inline constexpr double block_gap = 26;   // between two blocks: an arrow
inline constexpr double tap_offset = 26;  // of the line from a meter in a branch
inline constexpr double meter_radius = 12;

/// Width of a part's label, and of blocks with an arrow before each.
double label_width(const Part& part);
double blocks_width(const std::vector<BlockText>& blocks);
double tallest_block(const std::vector<BlockText>& blocks);

}  // namespace gyrator

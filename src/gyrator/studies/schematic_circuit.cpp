#include "gyrator/studies/schematic_layout.hpp"

#include <algorithm>

namespace gyrator {

// ---- Electrical side ----------------------------------------------------------------------------

// The amplifier's symbol between the rails, its left side at x_.
void SchematicLayout::draw_amplifier(Ink ink) {
  if (crosses_circuit()) {
    const double up = command_end_ + 2 * layout_gap;
    const double down = x_ + layout_gap;
    x_ = down + block_gap;
    canvas_.draw_arrow({{command_end_, middle_},
                        {up, middle_},
                        {up, command_y_},
                        {down, command_y_},
                        {down, middle_},
                        {x_, middle_}},
                       Ink::signal);
  } else {
    canvas_.draw_arrow({{command_end_, middle_}, {x_, middle_}}, Ink::signal);
  }
  x_ -= layout_gap;  // draw_branch keeps it free
  draw_branch({d_.amplifier}, ink);
}

void SchematicLayout::draw_electrical() {
  if (!d_.motor) return;
  if (!d_.amplifier_at_shaft) {
    draw_amplifier(Ink::wire);
  } else if (d_.across.empty()) {  // open terminals
    x_ += layout_gap;
    draw_terminal(canvas_, {x_, top_}, Ink::wire);
    draw_terminal(canvas_, {x_, bottom_}, Ink::wire);
    rail_from_ = return_from_ = x_ += 4;
  }
  for (const Part& part : d_.amplifier_output) {
    x_ += layout_gap;
    x_ += draw_on_rail(part, Ink::wire);
  }
  for (const Branch& branch : d_.across) draw_branch(branch, Ink::wire);
  draw_series();
  draw_motor();
}

// The current sensor, where anything reads it, and what is in series with the winding.
void SchematicLayout::draw_series() {
  x_ += layout_gap;
  if (d_.computer.sampled == Sampled::terminal_voltage) {
    terminal_x_ = x_ = std::max(x_, computer_end());
    x_ += layout_gap;
  }
  bool sensed = false;
  for (const SeriesPart& s : d_.in_series) sensed = sensed || !s.feedback.empty();
  for (std::size_t k = 0; k < d_.feedback.size(); ++k) {
    if (d_.feedback[k].tap > Tap::back_emf) continue;
    sensed = true;
    x_ = std::max(x_, end_of_lane(k));
  }
  if (sensed) {
    canvas_.draw_line({{rail_from_, top_}, {x_, top_}}, Ink::wire);
    current_x_ = x_ + 28;
    draw_part({Symbol::meter, "current sensor", "", {}, "A"}, {x_, top_}, {x_ + 56, top_},
              Ink::wire);
    rail_from_ = x_ += 56;
  }
  for (const SeriesPart& s : d_.in_series) draw_series_part(s);
  x_ += layout_gap;
  voltage_x_ = x_;
}

void SchematicLayout::draw_series_part(const SeriesPart& series) {
  if (series.feedback.empty()) {
    x_ += draw_on_rail(series.part, Ink::wire);
    return;
  }
  const double block = block_width(series.feedback);
  x_ = std::max(x_, current_x_ + 2 * block_gap + block - 32);
  const double length = draw_on_rail(series.part, Ink::wire);
  const double source_x = x_ + length / 2;
  const double block_x = (current_x_ + source_x) / 2;
  canvas_.draw_arrow(
      {{current_x_, top_ - meter_radius}, {current_x_, local_y_}, {block_x - block / 2, local_y_}},
      Ink::signal);
  draw_block(canvas_, {block_x, local_y_}, series.feedback);
  canvas_.draw_arrow({{block_x + block / 2, local_y_},
                      {source_x, local_y_},
                      {source_x, top_ - size_of(series.part.symbol).half_width}},
                     Ink::signal);
  x_ += length;
}

void SchematicLayout::draw_motor() {
  const double left = x_ + layout_gap;
  x_ = left + layout_gap;
  for (const Part& part : d_.motor->winding) x_ += draw_on_rail(part, Ink::wire);
  x_ = std::max(x_, left + 10 + measure_text(d_.motor->what)) + layout_gap;
  const double right = x_ + block_width(d_.motor->gyrator);
  canvas_.draw_line({{rail_from_, top_}, {x_, top_}}, Ink::wire);
  canvas_.draw_line({{return_from_, bottom_}, {x_, bottom_}}, Ink::wire);
  if (!d_.amplifier_at_shaft || !d_.across.empty()) draw_ground(canvas_, {return_from_, bottom_});
  draw_gyrator_box(right);
  // The housing, which takes the motor's reaction.
  canvas_.draw_line({{right, bottom_ - 16}, {right + 20, bottom_ - 16}, {right + 20, bottom_}},
                    Ink::shaft);
  draw_fixed_frame(canvas_, {right + 20, bottom_});
  canvas_.draw_box({left, top_ - 26}, {right + 42, bottom_ + 24}, Ink::frame);
  canvas_.draw_text({left + 10, bottom_ - 16}, d_.motor->what, Align::left);
  rail_from_ = right;
  x_ = right + 42;
}

void SchematicLayout::draw_gyrator_box(double right) {
  canvas_.begin_group(d_.motor->what);
  draw_gyrator(canvas_, {x_, top_ - 12}, {right, bottom_ + 12});
  canvas_.end_group();
  const auto lines = static_cast<double>(d_.motor->gyrator.size());
  double y = (top_ + 60 + bottom_) / 2 - 0.5 * line_height * (lines - 1);
  for (const auto& line : d_.motor->gyrator) {
    canvas_.draw_text({(x_ + right) / 2, y}, line, Align::middle, Letters::name);
    y += line_height;
  }
}

// ---- Mechanical side ----------------------------------------------------------------------------

void SchematicLayout::draw_mechanical() {
  if (d_.amplifier_at_shaft) draw_amplifier(Ink::shaft);
  for (const Branch& branch : d_.at_shaft) draw_branch(branch, Ink::shaft);
  if (d_.sensor_at_shaft) draw_sensor();
  draw_transmission();
  for (const Branch& branch : d_.at_load) draw_branch(branch, Ink::shaft);
  if (!d_.sensor_at_shaft) draw_sensor();
  for (std::size_t i = 0; i < d_.at_port.size(); ++i) {
    for (std::size_t k = 0; k < d_.feedback.size(); ++k)
      if (d_.feedback[k].tap == Tap::effort && d_.feedback[k].branch == i)
        x_ = std::max(x_, end_of_lane(k));
    branch_x_.push_back(draw_branch(d_.at_port[i], Ink::shaft));
    x_ = std::max(x_, branch_x_.back() + tap_offset);
  }
}

void SchematicLayout::draw_transmission() {
  if (d_.transmission.empty()) return;
  x_ += layout_gap;
  const double from = x_;
  const double damper_y = top_ + 84;
  double room = 0;
  for (const Part& part : d_.transmission)
    room = std::max(room, label_width(part) + 2 * layout_gap);
  x_ += draw_on_rail(d_.transmission.front(), Ink::shaft, room);
  if (d_.transmission.size() < 2) return;
  for (const double x : {from, x_}) {
    draw_junction(canvas_, {x, top_}, Ink::shaft);
    canvas_.draw_line({{x, top_}, {x, damper_y}}, Ink::shaft);
  }
  draw_part(d_.transmission[1], {from, damper_y}, {x_, damper_y}, Ink::shaft);
  draw_label_below(d_.transmission[1], (from + x_) / 2, damper_y);
}

void SchematicLayout::draw_operator() {
  x_ += 2 * layout_gap;
  canvas_.draw_line({{rail_from_, top_}, {x_ - 4, top_}}, Ink::shaft);
  draw_terminal(canvas_, {x_, top_}, Ink::shaft);
  canvas_.draw_text({x_, top_ - 18}, "port", Align::middle);
  const std::string label = "operator: " + d_.operator_kind;
  rail_from_ = x_ + 4;
  x_ += 24;
  if (d_.held_by.empty()) {
    canvas_.draw_text({x_ - 8, top_}, label, Align::left);
    x_ += measure_text(label);
    return;
  }
  const double left = x_;
  for (const Branch& branch : d_.held_by) draw_branch(branch, Ink::shaft, 14);
  x_ = std::max(x_ + layout_gap, left + measure_text(label) + 2 * layout_gap);
  canvas_.draw_box({left, top_ - 26}, {x_, bottom_ + 40}, Ink::frame);
  canvas_.draw_text({left + layout_gap, bottom_ + 24}, label, Align::left);
}

}  // namespace gyrator

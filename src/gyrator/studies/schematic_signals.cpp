#include "gyrator/studies/schematic_layout.hpp"

#include <algorithm>

namespace gyrator {
namespace {

constexpr double sum_pitch = 46;  // between two sums
constexpr double sampler_length = 40;

}  // namespace

// ---- The command: sums of the feedbacks, the outermost first, and the amplifier's loop
// ------------

void SchematicLayout::draw_command() {
  riser_x_ = layout_margin + 20;
  x_ = riser_x_;
  if (computer_sets_gains()) {  // nothing is commanded but by the feedbacks
    x_ += layout_gap;
    canvas_.draw_text({x_ - 4, middle_}, "0", Align::right);
  }
  sum_x_.resize(d_.feedback.size());
  for (std::size_t k = d_.feedback.size(); k-- > 0;) {
    sum_x_[k] = x_ + sum_pitch;
    canvas_.draw_arrow({{x_, middle_}, {sum_x_[k] - sum_radius, middle_}}, Ink::signal);
    draw_sum(canvas_, {sum_x_[k], middle_});
    x_ = sum_x_[k] + sum_radius;
  }
  for (const BlockText& block : d_.amplifier_loop) {
    const double half = block_width(block) / 2;
    canvas_.draw_arrow({{x_, middle_}, {x_ + block_gap, middle_}}, Ink::signal);
    draw_block(canvas_, {x_ + block_gap + half, middle_}, block);
    x_ += block_gap + 2 * half;
  }
  command_end_ = x_;
  x_ += crosses_circuit() ? 3 * layout_gap : block_gap;
}

// ---- The position sensor
// --------------------------------------------------------------------------

bool SchematicLayout::is_position_read() const {
  return d_.computer.sampled == Sampled::position ||
         std::any_of(d_.feedback.begin(), d_.feedback.end(),
                     [](const Feedback& f) { return f.tap == Tap::position; });
}

void SchematicLayout::draw_sensor() {
  if (!is_position_read()) return;
  // In an analog loop its block stands there, and only the tap is here.
  const bool sampled = d_.computer.sampled == Sampled::position;
  const double half = sampled ? block_width(d_.sensor) / 2 : 0;
  x_ = std::max(x_ + layout_gap, computer_end() - half);
  for (std::size_t k = 0; k < d_.feedback.size(); ++k)
    if (d_.feedback[k].tap == Tap::position) x_ = std::max(x_, end_of_lane(k) - half);
  sensor_x_ = x_ + half;
  canvas_.draw_line({{rail_from_, top_}, {sensor_x_, top_}}, Ink::shaft);
  draw_junction(canvas_, {sensor_x_, top_}, Ink::signal);
  rail_from_ = sensor_x_;
  x_ = sensor_x_ + half;
  if (!sampled) return;
  canvas_.draw_arrow({{sensor_x_, top_}, {sensor_x_, middle_ - block_height(d_.sensor) / 2}},
                     Ink::signal);
  draw_block(canvas_, {sensor_x_, middle_}, d_.sensor);
}

// ---- Feedbacks
// ------------------------------------------------------------------------------------

double SchematicLayout::end_of_lane(std::size_t k) const {
  return sum_x_[k] + layout_gap + blocks_width(d_.feedback[k].blocks) + block_gap;
}

void SchematicLayout::draw_lanes() {
  for (std::size_t k = 0; k < d_.feedback.size(); ++k) {
    const Feedback& f = d_.feedback[k];
    const double y = lane_y_[k];
    double x = current_x_;
    if (f.tap == Tap::position) x = sensor_x_;
    if (f.tap == Tap::effort) x = branch_x_[f.branch] + tap_offset;
    std::vector<BlockText> blocks = f.blocks;
    if (f.tap == Tap::back_emf) {
      x = draw_estimator(blocks.front(), y);
      blocks.erase(blocks.begin());
    }
    draw_lane(k, blocks, start_of(f, x, y));
  }
}

// The estimator above its two taps; returns its left side.
double SchematicLayout::draw_estimator(const BlockText& lines, double y) {
  const double height = block_height(lines);
  const double width = std::max(block_width(lines), voltage_x_ - current_x_ + 2 * layout_gap);
  const double right = voltage_x_ + layout_gap;
  const double foot = y + height / 2;
  canvas_.draw_arrow({{current_x_, top_ - meter_radius}, {current_x_, foot}}, Ink::signal);
  canvas_.draw_arrow({{voltage_x_, top_}, {voltage_x_, foot}}, Ink::signal);
  draw_junction(canvas_, {voltage_x_, top_}, Ink::signal);
  canvas_.draw_box({right - width, y - height / 2}, {right, foot}, Ink::signal);
  canvas_.draw_lines({right - width / 2, y}, lines, Align::middle, Letters::name);
  return right - width;
}

// The first points of a lane, from where it is tapped.
std::vector<Point> SchematicLayout::start_of(const Feedback& f, double x, double y) const {
  switch (f.tap) {
    case Tap::motor_current:
      return {{x, top_ - meter_radius}, {x, y}};
    case Tap::back_emf:
      return {{x, y}};
    case Tap::position:
      return {{x, top_}, {x, y}};
    case Tap::effort: {
      const auto parts = static_cast<double>(d_.at_port[f.branch].size());
      const double meter_y = top_ + (bottom_ - top_) / (2 * parts);  // the branch's first part
      return {{branch_x_[f.branch] + meter_radius, meter_y}, {x, meter_y}, {x, y}};
    }
  }
  return {};
}

void SchematicLayout::draw_lane(std::size_t k, const std::vector<BlockText>& blocks,
                                std::vector<Point> line) {
  const Feedback& f = d_.feedback[k];
  const double y = lane_y_[k];
  double x = line.back().x;
  for (const BlockText& block : blocks) {
    const double half = block_width(block) / 2;
    x -= block_gap;
    line.push_back({x, y});
    canvas_.draw_arrow(line, Ink::signal);
    draw_block(canvas_, {x - half, y}, block);
    if (f.set_by_computer) gains_to_ = {x - half, y - block_height(block) / 2};
    x -= 2 * half;
    line = {{x, y}};
  }
  line.push_back({sum_x_[k], y});
  line.push_back({sum_x_[k], middle_ - sum_radius});
  canvas_.draw_arrow(line, Ink::signal);
  canvas_.draw_text({sum_x_[k] + 8, middle_ - 22}, f.sign == '-' ? "−" : "+", Align::left);
}

// ---- The sampled side
// -----------------------------------------------------------------------------

double SchematicLayout::sampler_room() const {
  return std::max(sampler_length, measure_text(d_.computer.period) + layout_gap);
}

double SchematicLayout::computer_end() const {
  return riser_x_ + block_gap + blocks_width(d_.computer.blocks) + block_gap + sampler_room() +
         2 * layout_gap;
}

// The sampler, or under held gains only its period; returns where its signal ends.
double SchematicLayout::draw_sampler_in(double right) {
  const double y = computer_y_;
  const double middle = right - layout_gap - sampler_room() / 2;
  const double from = middle + sampler_length / 2;
  if (computer_sets_gains()) {
    canvas_.draw_text({middle, y}, d_.computer.period, Align::middle);
  } else {
    Point tap{sensor_x_, middle_ + block_height(d_.sensor) / 2};
    if (d_.computer.sampled == Sampled::terminal_voltage) {
      tap = {terminal_x_, top_};
      draw_junction(canvas_, tap, Ink::signal);
    }
    canvas_.draw_line({tap, {tap.x, y}, {from, y}}, Ink::signal);
    draw_sampler(canvas_, {from, y}, {from - sampler_length, y});
    canvas_.draw_text({middle, y + 18}, d_.computer.period, Align::middle);
  }
  return from - sampler_length;
}

void SchematicLayout::draw_computer() {
  const double y = computer_y_;
  const double half_height = tallest_block(d_.computer.blocks) / 2;
  const double right = computer_end() - layout_gap;
  double signal_end = draw_sampler_in(right);
  double x = right - layout_gap - sampler_room();
  bool reads = !computer_sets_gains();  // the first block computes gains from nothing
  for (const BlockText& block : d_.computer.blocks) {
    const double half = block_width(block) / 2;
    x -= block_gap;
    if (reads) canvas_.draw_arrow({{signal_end, y}, {x, y}}, Ink::signal);
    draw_block(canvas_, {x - half, y}, block);
    signal_end = x -= 2 * half;
    reads = true;
  }
  canvas_.draw_box({x - layout_gap, y - half_height - 12}, {right, y + half_height + 30},
                   Ink::frame);
  canvas_.draw_text({x, y + half_height + 17}, "computer", Align::left);
  if (computer_sets_gains()) {
    canvas_.draw_arrow(
        {{x, y}, {riser_x_, y}, {riser_x_, gains_y_}, {gains_to_.x, gains_y_}, gains_to_},
        Ink::signal);
  } else {
    canvas_.draw_line({{x, y}, {riser_x_, y}, {riser_x_, middle_}}, Ink::signal);
  }
  height_ = y + half_height + 30 + layout_margin;
  x_ = std::max(x_, right);
}

}  // namespace gyrator

#include "gyrator/studies/schematic.hpp"

#include "gyrator/studies/schematic_layout.hpp"

#include <algorithm>

namespace gyrator {
namespace {

constexpr double label_gap = 8;     // between a symbol and its label
constexpr double cell_height = 84;  // of one part in a branch
constexpr double least_width = 480;

std::vector<std::string> label_of(const Part& part) {
  std::vector<std::string> lines = part.values;
  if (!part.name.empty()) lines.insert(lines.begin(), part.name);
  return lines;
}

Letters letters_of(const Part& part) {
  return part.name.empty() ? Letters::plain : Letters::name;
}

}  // namespace

double label_width(const Part& part) {
  double widest = measure_text(part.name, Letters::name);
  for (const auto& line : part.values) widest = std::max(widest, measure_text(line));
  return widest;
}

double blocks_width(const std::vector<BlockText>& blocks) {
  double width = 0;
  for (const BlockText& block : blocks) width += block_width(block) + block_gap;
  return width;
}

double tallest_block(const std::vector<BlockText>& blocks) {
  double height = 0;
  for (const BlockText& block : blocks) height = std::max(height, block_height(block));
  return height;
}

Schematic draw_schematic(const Model& model) {
  const Diagram diagram = describe_device(model);
  return SchematicLayout(diagram).draw();
}

Schematic SchematicLayout::draw() {
  place_rows();
  draw_command();
  draw_electrical();
  draw_mechanical();
  draw_operator();
  draw_lanes();
  draw_computer();
  return finish();
}

// From top to bottom: title, held gains, feedbacks, the command of an effort source behind a motor,
// the feedback of a part in series, the rails, the computer.
void SchematicLayout::place_rows() {
  double y = layout_margin + 40;
  if (computer_sets_gains()) {
    gains_y_ = y;
    y += layout_gap;
  }
  lane_y_.resize(d_.feedback.size());
  for (std::size_t k = d_.feedback.size(); k-- > 0;) {  // the outermost is on top
    const double height = std::max(10.0, tallest_block(d_.feedback[k].blocks));
    lane_y_[k] = y + height / 2;
    y += height + layout_gap + 6;
  }
  if (crosses_circuit()) {
    command_y_ = y;
    y += layout_gap;
  }
  double local = 0;
  for (const SeriesPart& s : d_.in_series)
    if (!s.feedback.empty()) local = std::max(local, block_height(s.feedback));
  local_y_ = y + local / 2;
  top_ = y + local + 38;
  bottom_ = top_ + cell_height * static_cast<double>(std::max<std::size_t>(2, most_parts()));
  middle_ = (top_ + bottom_) / 2;
  computer_y_ = bottom_ + 58 + tallest_block(d_.computer.blocks) / 2;
}

std::size_t SchematicLayout::most_parts() const {
  std::size_t most = 0;
  for (const auto* list : {&d_.across, &d_.at_shaft, &d_.at_load, &d_.at_port, &d_.held_by})
    for (const Branch& branch : *list) most = std::max(most, branch.size());
  return most;
}

bool SchematicLayout::crosses_circuit() const {
  return d_.amplifier_at_shaft && d_.motor.has_value();
}

// One branch with its labels on the right; returns where its line is.
double SchematicLayout::draw_branch(const Branch& branch, Ink ink, double least_half_width) {
  double half_width = least_half_width;
  double label = 0;
  for (const Part& part : branch) {
    half_width = std::max(half_width, size_of(part.symbol).half_width);
    label = std::max(label, label_width(part));
  }
  const double x = x_ + layout_gap + half_width;
  if (branch.empty()) canvas_.draw_line({{x, top_}, {x, bottom_}}, ink);
  const double cells = static_cast<double>(std::max<std::size_t>(1, branch.size()));
  const double height = (bottom_ - top_) / cells;
  for (std::size_t i = 0; i < branch.size(); ++i) {
    const double from = top_ + height * static_cast<double>(i);
    draw_part(branch[i], {x, from}, {x, from + height}, ink);
    canvas_.draw_lines({x + size_of(branch[i].symbol).half_width + label_gap, from + height / 2},
                       label_of(branch[i]), Align::left, letters_of(branch[i]));
  }
  join_rail(x, ink, !branch.empty() && branch.back().symbol == Symbol::mass);
  x_ = x + half_width + (label > 0 ? label_gap + label : 0);
  return x;
}

void SchematicLayout::join_rail(double x, Ink ink, bool floats) {
  if (rail_from_ >= 0) {
    canvas_.draw_line({{rail_from_, top_}, {x, top_}}, ink);
    draw_junction(canvas_, {x, top_}, ink);
  }
  rail_from_ = x;
  if (ink == Ink::shaft) {
    if (!floats) draw_fixed_frame(canvas_, {x, bottom_});
  } else if (return_from_ < 0) {
    return_from_ = x;
  } else {
    draw_junction(canvas_, {x, bottom_}, ink);
  }
}

// A part on the upper rail from x_ on, at least `room` long; returns its length.
double SchematicLayout::draw_on_rail(const Part& part, Ink ink, double room) {
  const double length = std::max({room, label_width(part) + layout_gap, 64.0});
  if (rail_from_ < x_) canvas_.draw_line({{rail_from_, top_}, {x_, top_}}, ink);
  // A source in series drives the current on, to the right.
  draw_part(part, {x_ + length, top_}, {x_, top_}, ink);
  draw_label_below(part, x_ + length / 2, top_);
  rail_from_ = x_ + length;
  return length;
}

void SchematicLayout::draw_part(const Part& part, Point a, Point b, Ink ink) {
  canvas_.begin_group(part.what);
  draw_symbol(canvas_, part.symbol, a, b, ink, part.letter);
  canvas_.end_group();
}

void SchematicLayout::draw_label_below(const Part& part, double x, double y) {
  const auto lines = label_of(part);
  const double half = 0.5 * line_height * static_cast<double>(lines.size());
  canvas_.draw_lines({x, y + size_of(part.symbol).half_width + 4 + half}, lines, Align::middle,
                     letters_of(part));
}

Schematic SchematicLayout::finish() {
  const double width = std::max(x_ + layout_margin, least_width);
  canvas_.draw_text({layout_margin, layout_margin + 8},
                    fit_text(d_.title, width - 2 * layout_margin, Letters::title), Align::left,
                    Letters::title);
  return {canvas_.finish(width, height_, d_.title, describe_in_words(d_)), width, height_,
          canvas_.texts(), canvas_.strokes()};
}

}  // namespace gyrator

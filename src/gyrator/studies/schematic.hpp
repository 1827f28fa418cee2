#pragma once

#include "gyrator/plots/svg_canvas.hpp"
#include "gyrator/studies/model_file.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// A drawing of the device with everything that it is made of.
struct Schematic {
  std::string svg;             ///< the whole file
  double width = 0;            ///< [px]
  double height = 0;           ///< [px]
  std::vector<TextBox> texts;  ///< where each text lies; no two overlap, and no stroke meets one
  std::vector<Stroke> strokes;
};

/// Draws a model from left to right: amplifier, circuits across the motor, motor, mechanics,
/// operator. Upright between two rails stand the branches (mechanical ones too: velocity is an
/// across quantity as voltage is); below, from right to left, the sampled side closes the loop;
/// above run the feedbacks, each inside the next. The same model gives the same bytes.
Schematic draw_schematic(const Model& model);

}  // namespace gyrator

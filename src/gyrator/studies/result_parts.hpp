#pragma once

#include "gyrator/core/error.hpp"
#include "gyrator/studies/model_file.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What every result begins with: command, program, model and units.
nlohmann::json start_result(const char* command, const Model& model);

/// Infinite limits and radii have no JSON number: null.
nlohmann::json finite_or_null(double value);

/// Analyses know keys, not files: puts the model's name in front of what they refuse.
template <class Function>
auto naming_file(const Model& model, const Function& analyse) {
  try {
    return analyse();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::bad_input) throw;
    throw Error(error.code(), model.file + ": /" + error.place(), error.message());
  }
}

}  // namespace gyrator

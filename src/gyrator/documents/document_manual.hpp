#pragma once

#include "gyrator/documents/document_spec.hpp"

#include <string>

namespace gyrator {

/// Markdown for the manual: a section per object with a table of key, unit, default, allowed and
/// meaning. Objects with the same table (a velocity estimator in each controller) share a section
/// whose heading names all places: those that differ in one choice of a kind as one, "a(x, y).b",
/// or "a(*).b" for every kind. An object that lacks only a few of the keys shares it too, and the
/// section tells which.
std::string write_manual_table(const ObjectSpec& spec);

/// The same for a document that is one of several (a variant).
std::string write_manual_table(const Member& root);

}  // namespace gyrator

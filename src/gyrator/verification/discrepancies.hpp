#pragma once

#include "gyrator/verification/certificate_check.hpp"

#include <complex>
#include <string>
#include <vector>

namespace gyrator {

using Discrepancies = std::vector<Discrepancy>;

// How well two computations must agree, relative unless said otherwise.
inline constexpr double stable_pole = 1e-9;  // absolute; a pole of one is known to rounding only
inline constexpr double same_pole = 1e-6;    // absolute; it may be a double one
inline constexpr double number_agreement = 1e-9;  // of numbers written with double precision
inline constexpr double margin_rounding = 4e-15;  // of the terms that D is the difference of
inline constexpr double record_rounding = 2e-11;  // of D's terms: what the record reserves
inline constexpr double frequency_agreement = 1e-9;

void report(Discrepancies& list, std::string field, std::string reason);
/// Reports where recorded and found differ by more than an absolute tolerance, or are not numbers.
void compare(Discrepancies& list, const std::string& field, double recorded, double found,
             double tolerance);

std::complex<double> narrow(std::complex<long double> z);

}  // namespace gyrator

#pragma once

namespace gyrator {

/// A value with its standard deviation, and of how many independent errors that was found.
struct Estimate {
  double value = 0;
  double deviation = 0;  ///< in the value's unit
  double degrees = 1;    ///< of freedom, any number above 0
};

struct Interval {
  double low = 0, high = 0;
};

/// The quantile of Student's t: a share p of all values lies below it. p in (0, 1).
double find_student_quantile(double p, double degrees);

/// value ± t((1 + c)/2; degrees) deviation, which covers the truth in a share c of all cases
/// where the errors are normal.                                                     (interval-1)
Interval find_interval(const Estimate& estimate, double confidence = 0.99);

/// The product of two estimates with independent errors,
///   s^2 = (y s_x)^2 + (x s_y)^2,
/// with the degrees of freedom of Welch and Satterthwaite,
///   n = s^4/((y s_x)^4/n_x + (x s_y)^4/n_y).                                       (interval-2)
Estimate multiply(const Estimate& x, const Estimate& y);

/// The same value with one more independent error, of known deviation.
Estimate add_error(const Estimate& estimate, double deviation);

}  // namespace gyrator

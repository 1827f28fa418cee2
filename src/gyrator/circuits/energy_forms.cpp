#include "gyrator/circuits/energy_forms.hpp"

#include <variant>
#include <vector>

namespace gyrator {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;

// The quadratic form (z'a')(b z), symmetric. Kept as its two rows, of which most entries are zero,
// until it is added to a sum.
struct Outer {
  const RowVectorXd& a;
  const RowVectorXd& b;
  double factor = 1;
};
Outer outer(const RowVectorXd& a, const RowVectorXd& b) {
  return {a, b};
}
Outer operator*(const Outer& o, double by) {
  return {o.a, o.b, o.factor * by};
}
Outer operator/(const Outer& o, double by) {
  return {o.a, o.b, o.factor / by};
}
MatrixXd& operator+=(MatrixXd& sum, const Outer& o) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index i = 0; i < o.a.size(); ++i) {
    if (o.a(i) != 0 || o.b(i) != 0) used.push_back(i);
  }
  const double half = o.factor / 2;
  for (const auto j : used) {
    for (const auto i : used) sum(i, j) += half * (o.a(j) * o.b(i) + o.b(j) * o.a(i));
  }
  return sum;
}
MatrixXd& operator-=(MatrixXd& sum, const Outer& o) {
  return sum += o * -1;
}

RowVectorXd joined(const RowVectorXd& a, const RowVectorXd& b) {
  RowVectorXd row(a.size() + b.size());
  row << a, b;
  return row;
}

bool is_source(const ElementLaw& law) {
  return std::holds_alternative<VoltageSource>(law) || std::holds_alternative<CurrentSource>(law) ||
         std::holds_alternative<VoltageControlledVoltageSource>(law) ||
         std::holds_alternative<VoltageControlledCurrentSource>(law) ||
         std::holds_alternative<CurrentControlledVoltageSource>(law) ||
         std::holds_alternative<CurrentControlledCurrentSource>(law) ||
         std::holds_alternative<IdealOpAmp>(law) ||
         std::holds_alternative<ConstantVoltageSource>(law) ||
         std::holds_alternative<ConstantCurrentSource>(law) ||
         (is_nonlinear(law) &&
          (kind_of(law) == LawKind::voltage_source || kind_of(law) == LawKind::current_source));
}

}  // namespace

EnergyForms build_energy_forms(const NetworkEquations& equations, const Reduction& reduction,
                               std::optional<ElementId> operator_ammeter) {
  const Eigen::Index n = reduction.A.rows();
  const Eigen::Index m = reduction.B.cols();
  const MatrixXd zero = MatrixXd::Zero(n + m, n + m);
  EnergyForms forms{zero, zero, zero, zero, MatrixXd::Zero(n + 2 * m, n + 2 * m)};
  const auto row_of = [&](const LinearForm& form) {
    const ReducedForm r = reduction.reduce(form);
    return joined(r.state, r.input);
  };

  const auto& elements = equations.network().elements();
  for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
    const ElementId id{e};
    const Element& element = elements[static_cast<std::size_t>(e)];
    if (operator_ammeter && id == *operator_ammeter) {
      forms.operator_work +=
          outer(row_of(equations.across(element.positive)), row_of(equations.through(id)));
      continue;
    }
    if (element.role != Role::device && element.role != Role::supply) continue;
    const RowVectorXd across = row_of(equations.across(id));
    if (const auto* r = std::get_if<Resistor>(&element.law)) {
      forms.dissipated += outer(across, across) / r->resistance;
    } else if (const auto* g = std::get_if<Conductance>(&element.law)) {
      forms.dissipated += outer(across, across) * g->conductance;
    } else if (const auto* c = std::get_if<Capacitor>(&element.law)) {
      forms.stored += outer(across, across) * c->capacitance / 2;
    } else if (const auto* l = std::get_if<Inductor>(&element.law)) {
      const RowVectorXd current = row_of(equations.through(id));
      forms.stored += outer(current, current) * l->inductance / 2;
    } else if (const auto* coupling = std::get_if<MutualInductance>(&element.law)) {
      forms.stored += outer(row_of(equations.through(coupling->first)),
                            row_of(equations.through(coupling->second))) *
                      coupling->inductance;
    } else if (is_source(element.law) || element.role == Role::supply) {
      const ReducedForm v = reduction.reduce(equations.across(id));
      const ReducedForm i = reduction.reduce(equations.through(id));
      forms.source -= outer(joined(v.state, v.input), joined(i.state, i.input));
      // While u goes from u_a to u_b at constant w, an impulse i.rate (u_b - u_a) meets the mean of
      // v before and after, and likewise the other way round.
      const RowVectorXd none = RowVectorXd::Zero(n);
      const auto mean = [&](const ReducedForm& f) {
        return joined(joined(f.state, f.input / 2), f.input / 2);
      };
      const auto impulse = [&](const ReducedForm& f) {
        return joined(joined(none, -f.input_rate), f.input_rate);
      };
      forms.source_jump -= outer(mean(v), impulse(i));
      forms.source_jump -= outer(mean(i), impulse(v));
    } else if (is_nonlinear(element.law)) {
      forms.dissipated += outer(across, row_of(equations.through(id)));
    }
  }
  return forms;
}

}  // namespace gyrator

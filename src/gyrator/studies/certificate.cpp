#include "gyrator/studies/certificate.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/digest.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

json matrix_json(const Eigen::MatrixXd& matrix) {
  json rows = json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

json state_space_json(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& C,
                      const Eigen::MatrixXd& D) {
  return {
      {"A", matrix_json(A)}, {"B", matrix_json(B)}, {"C", matrix_json(C)}, {"D", matrix_json(D)}};
}

json law_json(const DiscreteStateSpace& law) {
  return state_space_json(law.A, law.B, law.C, Eigen::MatrixXd::Constant(1, 1, law.D));
}

json device_json(const Device& device) {
  const PortModel model(device);
  const StateSpace& system = model.blocked().system;
  json result = state_space_json(system.A, system.B, system.C, system.D);
  result["port_inertia"] = model.blocked().inertia;
  return result;
}

json intervals_json(const DiskProof& proof) {
  json columns = json::object();
  const auto column = [&](const char* name, const auto& value_of) {
    json values = json::array();
    for (const auto& interval : proof.intervals) values.push_back(value_of(interval));
    columns[name] = std::move(values);
  };
  using I = ProvedInterval;
  column("omega", [](const I& i) { return i.omega; });
  column("reach", [](const I& i) { return i.reach; });
  column("law_real", [](const I& i) { return i.law.real(); });
  column("law_imag", [](const I& i) { return i.law.imag(); });
  column("center_real", [](const I& i) { return i.center.real(); });
  column("center_imag", [](const I& i) { return i.center.imag(); });
  column("radius", [](const I& i) { return i.radius; });
  column("margin", [](const I& i) { return i.margin; });
  column("slope", [](const I& i) { return i.slope; });
  column("curvature", [](const I& i) { return i.curvature; });
  return columns;
}

json passive_loop_json(const JudgedLoop& loop) {
  return {{"name", loop.name},
          {"law", law_json(loop.law)},
          {"uncoupled_spectral_radius", loop.uncoupled_spectral_radius},
          {"lowest_omega", loop.proof.lowest_omega},
          {"lowest_margin", loop.proof.margin},
          {"direct_aliases", loop.proof.aliases},
          {"bounded_aliases", loop.proof.bounded_aliases},
          {"intervals", intervals_json(loop.proof)}};
}

json breaking_operator_json(const Counterexample& found) {
  json resonators = json::array();
  for (const auto& r : found.held_by.resonators)
    resonators.push_back({{"inertia", r.inertia}, {"stiffness", r.stiffness}});
  return {{"kind", "operator"},
          {"inertia", found.held_by.inertia},
          {"damping", found.held_by.damping},
          {"stiffness", found.held_by.stiffness},
          {"resonators", resonators},
          {"spectral_radius", found.spectral_radius},
          {"frequency_hz", found.frequency_hz}};
}

// What refutes the loop, the plainest first.
json refutation_json(const Model& model, const Verdict& verdict, const JudgedLoop& loop) {
  if (!verdict.device_passive) {
    return {{"kind", "device"},
            {"omega", 2 * std::numbers::pi * verdict.least_damping_frequency_hz},
            {"damping", verdict.least_damping}};
  }
  if (loop.uncoupled_spectral_radius > 1 + stability_tolerance)
    return {{"kind", "uncoupled"}, {"spectral_radius", loop.uncoupled_spectral_radius}};
  if (verdict.counterexample) return breaking_operator_json(*verdict.counterexample);
  const DiskPoint& worst = verdict.worst_disk;
  const auto law =
      loop.law.response(std::polar(1.0, worst.omega * model.sampling.period.to_double()));
  const double margin = worst.damping_margin(law);
  if (loop.proof.outcome == ProofOutcome::proved) {
    throw Error(ErrorCode::numerical, model.file,
                "no certificate: the loop is unstable with the port held still, which the format "
                "has no form for");
  }
  if (!(margin <= 0) || !std::isfinite(worst.radius)) {
    throw Error(ErrorCode::numerical, model.file,
                fmt::format("no certificate: at {:.4g} Hz the margin could not be decided",
                            loop.proof.omega / (2 * std::numbers::pi)));
  }
  return {{"kind", "disk"},
          {"omega", worst.omega},
          {"law_real", law.real()},
          {"law_imag", law.imag()},
          {"center_real", worst.center.real()},
          {"center_imag", worst.center.imag()},
          {"radius", worst.radius},
          {"margin", margin}};
}

}  // namespace

json make_certificate(const Model& model, const Verdict& verdict) {
  json certificate = start_result("certificate", model);
  certificate["schema"] = certificate_schema_name;
  certificate["verdict"] = verdict.passive ? "passive" : "not_passive";
  certificate["explanation"] = verdict.explanation;
  certificate["period_s"] = model.sampling.period.to_string();
  certificate["delay_s"] = model.sampling.delay.to_string();
  certificate["device"] = device_json(model.device);
  certificate["loops"] = json::array();
  if (verdict.passive) {
    for (const auto& loop : verdict.loops) certificate["loops"].push_back(passive_loop_json(loop));
  } else {
    const JudgedLoop& loop = verdict.loops.front();
    certificate["loops"].push_back({{"name", loop.name},
                                    {"law", law_json(loop.law)},
                                    {"refutation", refutation_json(model, verdict, loop)}});
  }
  certificate["digest"] = compute_digest(certificate);
  return certificate;
}

std::string canonical_text(const json& certificate) {
  json content = certificate;
  content.erase("digest");
  return content.dump();
}

std::string compute_digest(const json& certificate) {
  return "sha256:" + compute_sha256(canonical_text(certificate));
}

}  // namespace gyrator

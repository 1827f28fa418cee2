#include "gyrator/studies/certificate_verification.hpp"

#include "gyrator/circuits/descriptor_response.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/studies/certificate.hpp"
#include "gyrator/studies/certificate_reader.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/result_parts.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Complex = std::complex<double>;

constexpr int device_frequencies = 80;
constexpr int law_frequencies = 48;
// A response from the network's equations against the state space made of them; both in double
// precision. The impedance stands beside the inertia that is rigid with the port.
constexpr double same_response = 1e-7;
constexpr double same_digits = 1e-11;
constexpr double same_law = 1e-9;

struct ExpectedLoop {
  std::string name;
  DiscreteStateSpace law;
};

// The loops that a passive verdict rests on; one that is not passive names one of them.
std::vector<ExpectedLoop> expect_loops(const Model& model) {
  const Controller controller = model.sampled_controller();
  const double period = model.sampling.period.to_double();
  std::vector<ExpectedLoop> loops{{"in_contact", make_contact_law(controller, period)}};
  const auto* coupling = std::get_if<VirtualCoupling>(&controller.law);
  if (coupling && coupling->wall && coupling->wall->unilateral) {
    Controller free = controller;
    std::get<VirtualCoupling>(free.law).wall.reset();
    loops.push_back({"free", make_contact_law(free, period)});
  }
  return loops;
}

// Hand and gesture have no part in the verdict, but may name files of their own.
json judged_part(json model) {
  if (model.is_object()) {
    model.erase("operator");
    model.erase("simulation");
  }
  return model;
}

class Verifier {
 public:
  Verifier(const json& certificate, std::string file)
      : certificate_(certificate), file_(std::move(file)) {}

  CertificateVerification verify() {
    try {
      check();
    } catch (const Error& error) {
      if (error.code() == ErrorCode::interrupted) throw;
      report(error.place(), error.message());
    }
    return std::move(result_);
  }

 private:
  void report(const std::string& field, const std::string& reason) {
    result_.discrepancies.push_back({field, reason});
  }

  void expect_text(const char* field, const std::string& found) {
    const std::string recorded = read_text(certificate_, "", field);
    if (recorded != found) report(field, fmt::format("recorded {}: found {}", recorded, found));
  }

  void require_text(const char* field, const std::string& required) {
    const std::string recorded = read_text(certificate_, "", field);
    if (recorded != required)
      report(field, fmt::format("recorded {}: must be {}", recorded, required));
  }

  void check() {
    require_members(certificate_, "",
                    {"schema", "command", "program", "model_name", "model", "units", "verdict",
                     "explanation", "period_s", "delay_s", "device", "loops", "digest"});
    require_text("schema", certificate_schema_name);
    require_text("command", "certificate");
    if (!read_text(certificate_, "", "program").starts_with("gyrator "))
      report("program", "is not gyrator");
    expect_text("digest", compute_digest(certificate_));
    result_.verdict = read_text(certificate_, "", "verdict");
    const Model model = parse_model(judged_part(certificate_["model"]), file_);
    result_.model_name = model.name;
    result_.damping_unit = units_of(model.device.motion).damping.symbol;
    expect_text("model_name", model.name);
    if (certificate_["units"] != unit_names(model.device.motion))
      report("units", "are not those of the model's motion");
    expect_text("period_s", model.sampling.period.to_string());
    expect_text("delay_s", model.sampling.delay.to_string());
    check_verdict();
    const HeldDevice device = read_held_device(certificate_["device"]);
    for (const auto& d : check_device_shape(device)) report(d.field, d.reason);
    if (!result_.verified()) return;
    check_device(model, device);
    if (!result_.verified()) return;
    check_loops(model, device);
  }

  void check_verdict() {
    const bool passive = result_.verdict == "passive";
    if (!passive && result_.verdict != "not_passive")
      report("verdict", result_.verdict + ": must be passive or not_passive");
    const std::string explanation = read_text(certificate_, "", "explanation");
    if (explanation.starts_with("No passive operator can make the loop unstable") != passive)
      report("explanation", "does not say what the verdict says");
  }

  // Z, A, S and M of (port-1) by the network's own equations.
  void check_device(const Model& model, const HeldDevice& device) {
    const DeviceNetwork network = build_device_network(model.device, FreeOperator{});
    const NetworkEquations equations(network.network);
    const LinearForm port = equations.across(network.port);
    const LinearForm sensed = find_sensed_rate(network, equations);
    DescriptorResponse response(equations.descriptor());
    if (network.collocated != device.collocated()) {
      report("device/C", fmt::format("{} outputs: the model's sensor needs {}",
                                     device.system.C.rows(), network.collocated ? 1 : 2));
      return;
    }
    double slowest = std::numbers::pi / model.sampling.period.to_double();
    double fastest = slowest;
    const Eigen::MatrixXd& A = device.system.A;
    const Eigen::VectorXcd poles = A.rows() > 0 ? compute_poles(A) : Eigen::VectorXcd();
    for (const Complex& pole : poles) {
      fastest = std::max(fastest, std::abs(pole));
      if (std::abs(pole) > 1e-9 * fastest) slowest = std::min(slowest, std::abs(pole));
    }
    const double low = 1e-3 * slowest;
    const double high = 1e2 * fastest;
    for (int i = 0; i < device_frequencies; ++i) {
      const double omega = low * std::pow(high / low, i / (device_frequencies - 1.0));
      const Eigen::MatrixXcd& x = response.solve(Complex(0, omega));
      const Complex y_pu = (port.x * x)(0);
      const Complex y_pp = (port.x * x)(1);
      const HeldResponse r = compute_held_response(device, omega);
      const Complex z = narrow(r.impedance);
      const Complex beside = z - Complex(0, omega * device.port_inertia);
      compare("Z", omega, z, 1.0 / y_pp,
              same_response * std::abs(beside) + same_digits * std::abs(z));
      compare("A", omega, narrow(r.actuation), y_pu / y_pp, 0);
      if (network.collocated) continue;
      const Complex path = (sensed.x * x)(1) / y_pp;
      compare("S", omega, narrow(r.sensor_path), path, 0);
      const Complex free = (sensed.x * x)(0);
      compare("M", omega, narrow(r.blocked), free - path * y_pu,
              same_digits * (std::abs(free) + std::abs(path * y_pu)));
    }
  }

  static Complex narrow(std::complex<long double> z) {
    return {static_cast<double>(z.real()), static_cast<double>(z.imag())};
  }

  void compare(const char* name, double omega, Complex recorded, Complex found, double tolerance) {
    const double off = std::abs(recorded - found);
    const double allowed = tolerance > 0 ? tolerance : same_response * std::abs(found);
    // Where a difference of larger numbers is nothing but rounding, it has no relative size.
    if (std::abs(found) > tolerance)
      result_.device_difference = std::max(result_.device_difference, off / std::abs(found));
    if (off <= allowed || !result_.verified()) return;
    report("device",
           fmt::format("its {} at {:.6g} rad/s is {:.9g} {:+.9g}j: the model's is {:.9g} {:+.9g}j",
                       name, omega, recorded.real(), recorded.imag(), found.real(), found.imag()));
  }

  static std::vector<double> spread_frequencies(double period) {
    const double nyquist = std::numbers::pi / period;
    std::vector<double> frequencies;
    for (int i = 0; i < law_frequencies; ++i) {
      // Half of them towards zero, where integrators and differences show.
      frequencies.push_back(i % 2 == 0 ? nyquist * (i + 2) / (law_frequencies + 0.0)
                                       : nyquist * std::pow(10.0, -4.0 * i / law_frequencies));
    }
    return frequencies;
  }

  void check_law(const DiscreteStateSpace& recorded, const ExpectedLoop& expected, double period,
                 const std::vector<double>& frequencies, const std::string& place) {
    for (const double omega : frequencies) {
      const Complex found = narrow(compute_law(expected.law, omega * period));
      const double off = std::abs(narrow(compute_law(recorded, omega * period)) - found);
      const double size = std::abs(found) + same_digits * std::abs(expected.law.D);
      result_.law_difference = std::max(result_.law_difference, off / std::max(1e-300, size));
      if (off <= same_law * size) continue;
      report(place + "/law",
             fmt::format("H at {:.6g} rad/s is off by {:.6g} from the model's {:.9g} {:+.9g}j",
                         omega, off, found.real(), found.imag()));
      return;
    }
  }

  void check_loops(const Model& model, const HeldDevice& device) {
    const json& loops = certificate_["loops"];
    if (!loops.is_array()) throw Error(ErrorCode::bad_input, "loops", "a list is expected");
    const std::vector<ExpectedLoop> expected = expect_loops(model);
    const bool passive = result_.verdict == "passive";
    if (loops.size() != (passive ? expected.size() : 1)) {
      report("loops", fmt::format("recorded {}: the verdict rests on {}", loops.size(),
                                  passive ? expected.size() : 1));
      return;
    }
    for (std::size_t i = 0; i < loops.size(); ++i) {
      const std::string place = fmt::format("loops/{}", i);
      const json& loop = loops[i];
      if (!loop.is_object() || !loop.contains("name") || !loop.contains("law"))
        throw Error(ErrorCode::bad_input, place, "a loop with name and law is expected");
      const std::string name = read_text(loop, place, "name");
      const auto named = std::find_if(expected.begin(), expected.end(),
                                      [&](const auto& e) { return e.name == name; });
      if (named == expected.end() || (passive && name != expected[i].name)) {
        report(place + "/name", name + ": is not the loop that is expected");
        return;
      }
      const DiscreteStateSpace law = read_law(loop, place);
      const double period = model.sampling.period.to_double();
      check_law(law, *named, period, spread_frequencies(period), place);
      if (passive) {
        check_passive(loop, place, model, device, *named);
      } else {
        check_not_passive(loop, place, model, device, law);
      }
    }
  }

  void check_passive(const json& loop, const std::string& place, const Model& model,
                     const HeldDevice& device, const ExpectedLoop& expected) {
    const CertifiedLoop certified = read_certified_loop(loop, place);
    result_.loops.push_back({loop["name"], certified.lowest_margin, {}});
    if (!result_.verified()) return;
    // The intervals are close together where the law varies.
    std::vector<double> middles;
    for (const auto& interval : certified.intervals) middles.push_back(interval.omega);
    check_law(certified.law, expected, model.sampling.period.to_double(), middles, place);
    if (!result_.verified()) return;
    for (const auto& d :
         check_passive_loop(device, model.sampling, certified, result_.loops.back().found))
      report(place + "/" + d.field, d.reason);
  }

  void check_not_passive(const json& loop, const std::string& place, const Model& model,
                         const HeldDevice& device, const DiscreteStateSpace& law) {
    const Refutation refutation = read_refutation(loop, place);
    result_.refutation = loop["refutation"]["kind"];
    if (!result_.verified()) return;
    for (const auto& d : check_refutation(device, model.sampling, law, refutation))
      report(place + "/" + d.field, d.reason);
  }

  const json& certificate_;
  std::string file_;
  CertificateVerification result_;
};

}  // namespace

CertificateVerification verify_certificate(const json& certificate, const std::string& file) {
  const bool named = certificate.is_object() && certificate.contains("schema") &&
                     certificate["schema"].is_string() &&
                     certificate["schema"].get<std::string>().starts_with("gyrator/certificate");
  if (!named) {
    throw Error(
        ErrorCode::bad_input, file,
        "is not a certificate: write one with `gyrator passivity MODEL --certificate FILE`");
  }
  return Verifier(certificate, file).verify();
}

json make_verification_result(const CertificateVerification& verification,
                              const std::string& file) {
  json result{{"schema", "gyrator/result/1"},
              {"command", "verify-certificate"},
              {"program", fmt::format("gyrator {}", version)},
              {"certificate", file},
              {"model_name", verification.model_name},
              {"verdict", verification.verdict},
              {"verified", verification.verified()},
              {"device_difference", finite_or_null(verification.device_difference)},
              {"law_difference", finite_or_null(verification.law_difference)},
              {"refutation",
               verification.refutation.empty() ? json(nullptr) : json(verification.refutation)},
              {"loops", json::array()},
              {"discrepancies", json::array()}};
  for (const auto& loop : verification.loops) {
    const CheckedLoop& found = loop.found;
    result["loops"].push_back(
        {{"name", loop.name},
         {"intervals", found.intervals},
         {"enclosures", found.enclosures},
         {"smallest_margin", finite_or_null(found.smallest_margin)},
         {"recorded_lowest_margin", loop.recorded_lowest_margin},
         {"to_zero_frequency", found.to_zero},
         {"radius_ratio", {finite_or_null(found.tightest), finite_or_null(found.widest)}},
         {"spectral_radius", found.spectral_radius}});
  }
  for (const auto& d : verification.discrepancies)
    result["discrepancies"].push_back({{"field", d.field}, {"reason", d.reason}});
  return result;
}

}  // namespace gyrator

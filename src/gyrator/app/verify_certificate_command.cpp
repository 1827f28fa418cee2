#include "gyrator/core/text.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/studies/certificate_verification.hpp"

#include <chrono>
#include <memory>

#include <fmt/core.h>

#include "commands.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  std::string file;
  bool json = false;
};

std::string describe_loop(const CertificateVerification::Loop& loop, const std::string& unit) {
  const CheckedLoop& found = loop.found;
  const std::string disks =
      found.widest > 0
          ? fmt::format("each disk by brute force, the recorded ones up to {:.2g} % larger",
                        100 * (found.widest - 1))
          : "its law commands nothing, so that no disk matters";
  return fmt::format(
      "  {}: stable with nothing attached (spectral radius {:.9g}); {} (0, pi/T];\n"
      "    {};\n"
      "    margin at least {:.6g} {} between the points too, by {} of its own{}\n"
      "    (the certificate claims {:.6g} {})\n",
      loop.name, found.spectral_radius,
      describe_count(static_cast<std::size_t>(found.intervals), "interval covers",
                     "intervals cover"),
      disks, found.smallest_margin, unit,
      describe_count(static_cast<std::size_t>(found.enclosures), "enclosure"),
      found.to_zero ? ", down to zero frequency" : "; and below them to the limit",
      loop.recorded_lowest_margin, unit);
}

std::string describe(const CertificateVerification& v, const std::string& file, double seconds) {
  std::string text = fmt::format("{}: {}\n", file, v.verified() ? "VERIFIED" : "NOT VERIFIED");
  for (const auto& d : v.discrepancies) text += fmt::format("  {}: {}\n", d.field, d.reason);
  if (!v.verified()) return text;
  text += fmt::format("{}: {}\n", v.model_name, v.verdict == "passive" ? "PASSIVE" : "NOT PASSIVE");
  text += fmt::format(
      "  digest, and the device and law against the model's (within {:.1g} and {:.1g})\n",
      v.device_difference, v.law_difference);
  for (const auto& loop : v.loops) text += describe_loop(loop, v.damping_unit);
  if (v.refutation == "operator") text += "  the operator makes the loop diverge\n";
  if (v.refutation == "uncoupled") text += "  the loop diverges with nothing attached\n";
  if (v.refutation == "device") text += "  the bare device supplies energy at that frequency\n";
  if (v.refutation == "disk") text += "  the disk is exceeded at that frequency\n";
  return text + fmt::format("checked in {:.2g} s\n", seconds);
}

void run(const Options& options, int& exit_code) {
  const auto start = std::chrono::steady_clock::now();
  const CertificateVerification v = verify_certificate(load_json_file(options.file), options.file);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  exit_code = v.verified() ? 0 : 1;
  if (options.json) {
    nlohmann::json result = make_verification_result(v, options.file);
    result["seconds"] = seconds;
    fmt::print("{}\n", result.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    fmt::print("{}", describe(v, options.file, seconds));
  }
}

}  // namespace

void add_verify_certificate_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("verify-certificate",
                         "Check a passivity certificate by other methods than those that made it");
  command->add_option("FILE", options->file, "What passivity --certificate wrote (JSON)")
      ->required()
      ->check(not_empty());
  command->add_flag("--json", options->json, "Print the result as JSON");
  command->footer(
      "Example:\n  gyrator passivity examples/re25_display.json --certificate certificate.json; "
      "gyrator verify-certificate certificate.json\n\n"
      "Exit code 0: verified. 1: not verified, with the field that is not as found. 2: no "
      "certificate.");
  command->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace gyrator::app

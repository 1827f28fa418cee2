#pragma once

#include "gyrator/verification/certificate_check.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What came of checking a certificate.
struct CertificateVerification {
  std::string model_name, verdict;
  std::string damping_unit;  ///< of the margins
  std::string refutation;    ///< its kind; empty for a passive verdict
  struct Loop {
    std::string name;
    double recorded_lowest_margin = 0;
    CheckedLoop found;
  };
  std::vector<Loop> loops;                 ///< of a passive verdict
  double device_difference = 0;            ///< largest, of the device from its network, relative
  double law_difference = 0;               ///< of the laws from the model's controller
  std::vector<Discrepancy> discrepancies;  ///< none: verified

  bool verified() const { return discrepancies.empty(); }
};

/// Checks a certificate (docs/certificates.md) from its digest to its numbers, with the
/// verification room's own methods. That the device and the laws are the embedded model's is seen
/// from the network's descriptor equations at some dozens of frequencies and from make_contact_law
/// there and at the middle of every interval.
/// `file` is for messages, and netlists that the model names are looked for beside it. Throws
/// bad_input where the document is no certificate at all.
CertificateVerification verify_certificate(const nlohmann::json& certificate,
                                           const std::string& file);

/// The same as a document, for --json.
nlohmann::json make_verification_result(const CertificateVerification& verification,
                                        const std::string& file);

}  // namespace gyrator

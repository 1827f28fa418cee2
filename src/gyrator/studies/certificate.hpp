#pragma once

#include "gyrator/passivity/verdict.hpp"
#include "gyrator/studies/model_file.hpp"

#include <nlohmann/json.hpp>

namespace gyrator {

inline constexpr const char* certificate_schema_name = "gyrator/certificate/1";

/// Everything needed to check a verdict again without this program (docs/certificates.md): the
/// device as a state space with its port held, the law, the sampling, and
///   passive      per loop the intervals of frequency that cover (0, pi/T], with H, disk, margin,
///                slope and the bound on what lies between (ProvedInterval)
///   not passive  the operator that breaks the loop, or the frequency at which the disk is
///                exceeded, the device supplies energy, or the pole that grows with nothing
///                attached
/// and a digest over all of it (seal_certificate). Throws numerical where the verdict could not be
/// decided.
nlohmann::json make_certificate(const Model& model, const Verdict& verdict);

/// The text that the digest is taken over: the certificate without its digest, keys in order,
/// without spaces, numbers with the fewest digits that give them back.
std::string canonical_text(const nlohmann::json& certificate);

/// "sha256:…" over canonical_text.
std::string compute_digest(const nlohmann::json& certificate);

}  // namespace gyrator

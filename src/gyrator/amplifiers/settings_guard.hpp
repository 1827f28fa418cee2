#pragma once

#include "gyrator/amplifiers/experiment.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// Those of a bench's settings at whose zero nothing acts on the motor beside its command, by their
/// well-known names (docs/amplifiers.md) and in the order of switching off: cancellation, damping
/// circuit, back-EMF feedback.
std::vector<std::string> find_disturbing_settings(const Bench& bench);

/// Switches off what acts on the motor beside its command, and puts it back as it was.
///
/// Putting back begins with switching off what is on by now; then come the values, and last the
/// switches, in reverse of the order in which they were switched off: no circuit is ever closed on
/// half of its values. The destructor does it unless put_back() or keep() was called; what it
/// cannot write it leaves to the session behind the bench, whose journal has the values.
class SettingsGuard {
 public:
  /// `values`: names of further settings to put back; those that the bench does not have are left
  /// out, and those that it switches off count once. All are read before the first write. Throws
  /// what the bench does, with everything put back as far as that goes.
  explicit SettingsGuard(Bench& bench, const std::vector<std::string>& values = {});
  ~SettingsGuard() { put_back_quietly(); }
  SettingsGuard(const SettingsGuard&) = delete;
  SettingsGuard& operator=(const SettingsGuard&) = delete;
  SettingsGuard(SettingsGuard&&) = delete;
  SettingsGuard& operator=(SettingsGuard&&) = delete;

  /// Throws what the bench does; the destructor tries again then.
  void put_back();
  /// Everything stays as it is now.
  void keep() { is_over_ = true; }

 private:
  void put_back_quietly() noexcept;
  void close_again_quietly() noexcept;

  Bench& bench_;
  std::vector<Setting> switches_, values_;  // as they were
  bool is_over_ = false;
};

}  // namespace gyrator

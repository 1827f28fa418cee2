#pragma once

#include <string_view>

namespace gyrator {

/// Turns Ctrl-C (SIGINT) into a flag that long work looks at; to be called once, in main.
///
/// The first SIGINT only sets the flag, so that destructors run and no half-written file stays;
/// the second one ends the process as usual. Blocking system calls return with EINTR.
void install_interrupt_handler();

/// True once the user has pressed Ctrl-C (after install_interrupt_handler).
bool interrupt_requested();

/// From here on a Ctrl-C counts as heard: what was done until then can be written. Another one
/// still ends the process.
void acknowledge_interrupt();

/// Throws Error interrupted ("place: interrupted") once the user has pressed Ctrl-C.
/// Call it at safe points: between designs of a map, samples of a run, rows of a file.
void throw_if_interrupted(std::string_view place);

}  // namespace gyrator

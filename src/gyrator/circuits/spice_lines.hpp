#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// One statement of a SPICE file: continuation lines joined, comments gone.
struct SpiceLine {
  std::string place;  ///< "snubber.cir:12", the first of its lines
  std::string text;
};

/// `name=value` on a statement. The name in lower case; the value as written, braces and all.
struct SpiceAssignment {
  std::string name;
  std::string value;
};

/// A statement cut into its words; what is assigned stands apart, in order.
struct SpiceCard {
  std::string place;
  std::string text;
  std::vector<std::string> words;
  std::vector<SpiceAssignment> assignments;
};

/// The text without regard to case, as SPICE compares (ASCII letters only).
std::string lower_spice(std::string_view text);

/// The bytes of a SPICE file as UTF-8 with '\n' line ends.
///
/// UTF-8 and UTF-16 (LTspice) with or without byte order mark; what is neither is Latin-1. The
/// Greek mu becomes the micro sign. Throws bad_input for a file with NUL characters.
std::string decode_spice_text(std::string_view bytes, const std::string& file);

/// What the first line of a text is: of a deck its title, of an included file a line like others.
enum class SpiceFirstLine { title, statement };

/// The statements of a text: '*' lines and the tails from ';' or " $ " are comments, '+' continues.
///
/// A title is dropped; there is none where the first line starts with '.' or '*'. A first line that
/// reads as an element is refused, since SPICE would drop it without a word.
std::vector<SpiceLine> split_spice_lines(std::string_view text, const std::string& file,
                                         SpiceFirstLine first);

/// Cuts a statement into words at blanks, commas and lone parentheses. {…}, '…' and "…" stay whole,
/// as do parentheses inside a word: the node "Net-(C1-Pad1)". "params:" is dropped.
/// Throws bad_input for a brace or quote without end and for '=' without name or value.
SpiceCard parse_spice_card(const SpiceLine& line);

/// The assignments of a `.param` line; a value runs to the next `name =` and may hold blanks.
std::vector<SpiceAssignment> parse_spice_parameters(const SpiceLine& line);

}  // namespace gyrator

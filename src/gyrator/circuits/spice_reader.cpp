#include "gyrator/circuits/spice_reader.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include <fmt/core.h>

namespace gyrator {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t deepest_include = 16;
constexpr int most_includes = 1000;
constexpr std::size_t deepest_definition = 32;
constexpr std::size_t most_lines = 20'000;
constexpr std::uintmax_t largest_file = 16'000'000;  // bytes

// Control lines that say what to simulate and show, not what the circuit is.
constexpr std::array ignored_controls{
    ".tran",   ".ac",      ".op",    ".dc",       ".noise", ".tf",     ".four",  ".fft",
    ".meas",   ".measure", ".save",  ".print",    ".plot",  ".probe",  ".width", ".options",
    ".option", ".opt",     ".title", ".backanno", ".step",  ".nodeset"};
constexpr std::array read_controls{".subckt", ".ends", ".param", ".model",  ".include",
                                   ".inc",    ".lib",  ".end",   ".control"};

[[noreturn]] void refuse(const std::string& place, std::string message) {
  throw Error(ErrorCode::bad_input, place, std::move(message));
}

std::string read_file(const fs::path& path) {
  std::error_code ignored;
  std::ifstream stream(path, std::ios::binary);
  if (!fs::is_regular_file(path, ignored) || !stream) {
    refuse(path.string(), "the file does not exist or cannot be read");
  }
  const auto size = fs::file_size(path, ignored);
  if (size > largest_file) {
    refuse(path.string(), fmt::format("a file of {} bytes: at most {}", size, largest_file));
  }
  return {std::istreambuf_iterator<char>(stream), {}};
}

// A file's statements in order, included ones in place of the line that names their file.
class Inclusion {
 public:
  std::vector<SpiceLine> lines;
  std::vector<std::string> missing_libraries;
  std::vector<fs::path> included;  // with repetitions

  void add(std::string_view text, const fs::path& file, SpiceFirstLine first) {
    bool in_control = false;
    for (SpiceLine& line : split_spice_lines(text, file.string(), first)) {
      const std::string word = lower_spice(line.text.substr(0, line.text.find_first_of(" \t")));
      if (word == ".control") in_control = true;
      if (word == ".endc") {
        in_control = false;
      } else if (in_control) {
        continue;
      } else if (word == ".end") {
        break;
      } else if (word == ".include" || word == ".inc" || word == ".lib") {
        include(line, word, file);
      } else {
        if (lines.size() >= most_lines) {
          refuse(line.place,
                 fmt::format("more than {} lines with all that is included", most_lines));
        }
        lines.push_back(std::move(line));
      }
    }
  }

 private:
  void include(const SpiceLine& line, const std::string& word, const fs::path& file) {
    std::string_view name = trim(std::string_view(line.text).substr(word.size()));
    if (!name.empty() && (name[0] == '"' || name[0] == '\'')) {
      const auto end = name.find(name[0], 1);
      if (end == std::string_view::npos || !trim(name.substr(end + 1)).empty()) {
        refuse(line.place, fmt::format("'{}': one file name is read; sections of a library are not",
                                       line.text));
      }
      name = name.substr(1, end - 1);
    }
    if (name.empty()) refuse(line.place, fmt::format("'{}': a file name is missing", line.text));
    std::string portable(name);
    std::replace(portable.begin(), portable.end(), '\\', '/');
    const fs::path path = file.parent_path() / portable;
    std::error_code failed;
    if (!fs::is_regular_file(path, failed)) {
      // LTspice names its own libraries in every netlist; that is a fault only if one is needed.
      if (word != ".lib") {
        refuse(line.place,
               fmt::format("'{}': the file {} does not exist", line.text, path.string()));
      }
      missing_libraries.push_back(fmt::format("{}: {}", line.place, name));
      return;
    }
    const fs::path known = fs::weakly_canonical(path, failed);
    const auto cycle = std::find(open_.begin(), open_.end(), known);
    if (cycle != open_.end() || known == first_file(file)) {
      refuse(line.place, fmt::format("'{}': the file includes itself", line.text));
    }
    if (open_.size() >= deepest_include) {
      refuse(line.place, fmt::format("'{}': files include files more than {} deep", line.text,
                                     deepest_include));
    }
    if (++includes_ > most_includes) {
      refuse(line.place,
             fmt::format("'{}': more than {} files are included", line.text, most_includes));
    }
    open_.push_back(known);
    included.push_back(path);
    add(decode_spice_text(read_file(path), path.string()), path, SpiceFirstLine::statement);
    open_.pop_back();
  }

  // The outermost file, which no line named.
  fs::path first_file(const fs::path& current) {
    std::error_code failed;
    if (open_.empty()) first_ = fs::weakly_canonical(current, failed);
    return first_;
  }

  std::vector<fs::path> open_;
  int includes_ = 0;
  fs::path first_;
};

SpiceDefinition parse_header(const SpiceLine& line) {
  const SpiceCard card = parse_spice_card(line);
  if (card.words.size() < 2) {
    refuse(line.place, fmt::format("'{}': a subcircuit needs a name", line.text));
  }
  SpiceDefinition definition;
  definition.name = card.words[1];
  definition.place = line.place;
  for (std::size_t i = 2; i < card.words.size(); ++i) {
    const std::string pin = lower_spice(card.words[i]);
    if (pin == "0" || pin == "gnd") {
      refuse(line.place, fmt::format("'{}': {} is ground everywhere and cannot be a pin", line.text,
                                     card.words[i]));
    }
    if (std::find(definition.pins.begin(), definition.pins.end(), pin) != definition.pins.end()) {
      refuse(line.place, fmt::format("'{}': the pin {} is there twice", line.text, card.words[i]));
    }
    definition.pins.push_back(pin);
  }
  for (const auto& [name, value] : card.assignments) {
    definition.defaults.push_back({name, value, line.place});
  }
  return definition;
}

// ".model NAME TYPE(p=value …)", the parentheses as one likes.
SpiceModel parse_model(const SpiceLine& line) {
  std::string_view rest =
      trim(std::string_view(line.text).substr(std::string_view(".model").size()));
  const auto take = [&] {
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t("));
    rest = trim(rest.substr(word.size()));
    return std::string(word);
  };
  SpiceModel model;
  model.name = take();
  model.type = lower_spice(take());
  model.place = line.place;
  if (model.type != "d") return model;
  if (!rest.empty() && rest.front() == '(') {
    if (rest.back() != ')') refuse(line.place, fmt::format("'{}': '(' has no end", line.text));
    rest = rest.substr(1, rest.size() - 2);
  }
  model.card = parse_spice_card({line.place, fmt::format("{} {}", model.name, rest)});
  model.card.text = line.text;
  return model;
}

// Sorts statements into definitions.
class DeckParser {
 public:
  explicit DeckParser(const std::vector<SpiceLine>& lines) : lines_(lines) {}

  SpiceDefinition parse(const std::string& file) {
    SpiceDefinition top;
    top.place = file;
    parse_body(top, 0);
    return top;
  }

 private:
  void parse_body(SpiceDefinition& into, std::size_t depth) {
    while (at_ < lines_.size()) {
      const SpiceLine& line = lines_[at_++];
      const std::string word = lower_spice(line.text.substr(0, line.text.find_first_of(" \t")));
      if (word[0] != '.') {
        into.elements.push_back(parse_spice_card(line));
      } else if (word == ".subckt") {
        parse_definition(into, line, depth + 1);
      } else if (word == ".ends") {
        if (depth == 0) refuse(line.place, fmt::format("'{}': no .subckt before it", line.text));
        check_end(into, line);
        return;
      } else if (word == ".param" || word == ".params") {
        for (const auto& [name, value] : parse_spice_parameters(line)) {
          into.parameters.push_back({name, value, line.place});
        }
      } else if (word == ".model") {
        add_model(into, parse_model(line));
      } else if (std::find(ignored_controls.begin(), ignored_controls.end(), word) ==
                 ignored_controls.end()) {
        std::vector<std::string> known(read_controls.begin(), read_controls.end());
        known.insert(known.end(), ignored_controls.begin(), ignored_controls.end());
        refuse(line.place, fmt::format("'{}': {}", line.text,
                                       describe_unknown_name("control line", word, known)));
      }
    }
    if (depth > 0) {
      refuse(into.place, fmt::format("the subcircuit {} has no .ends", into.name));
    }
  }

  void parse_definition(SpiceDefinition& into, const SpiceLine& line, std::size_t depth) {
    if (depth > deepest_definition) {
      refuse(line.place, fmt::format("'{}': subcircuits stand in subcircuits more than {} deep",
                                     line.text, deepest_definition));
    }
    SpiceDefinition definition = parse_header(line);
    parse_body(definition, depth);
    const SpiceDefinition* first = into.find_definition(definition.name);
    if (first == nullptr) {
      into.definitions.push_back(std::move(definition));
    } else if (first->place != definition.place) {  // else the same file, included twice
      refuse(line.place, fmt::format("the subcircuit {} is defined a second time: first at {}",
                                     definition.name, first->place));
    }
  }

  // Of models that no element can use, a library may hold several of one name.
  static void add_model(SpiceDefinition& into, SpiceModel model) {
    const SpiceModel* first = into.find_model(model.name);
    if (first != nullptr && first->place == model.place) return;  // the file is included twice
    if (first != nullptr && (first->type == "d" || model.type == "d")) {
      refuse(model.place, fmt::format("the model {} is defined a second time: first at {}",
                                      model.name, first->place));
    }
    into.models.push_back(std::move(model));
  }

  static void check_end(const SpiceDefinition& definition, const SpiceLine& line) {
    const SpiceCard card = parse_spice_card(line);
    if (card.words.size() < 2 || lower_spice(card.words[1]) == lower_spice(definition.name)) return;
    refuse(line.place, fmt::format("'{}' ends the subcircuit {} of {}", line.text, definition.name,
                                   definition.place));
  }

  const std::vector<SpiceLine>& lines_;
  std::size_t at_ = 0;
};

// The single pole of `opamp` is a signal (it carries no power of the circuit); its output is an
// ideal source. '@' is a nullor: output between the first two nodes, inputs the others. '^' clamps
// the pole near the output's limit, so that it does not run far beyond and come back late.
constexpr std::string_view built_in_text = R"(
.subckt opamp inverting noninverting output Aol=100K GBW=10Meg Vmax=1e300
G1 0 pole noninverting inverting {Aol}
R1 pole 0 1
C1 pole 0 {Aol/(2*pi*GBW)}
^1 pole 0 {Vmax}
E1 output 0 pole 0 1 limit={Vmax}
.ends
.subckt ideal_opamp noninverting inverting output
@1 output 0 noninverting inverting
.ends
)";

}  // namespace

const SpiceDefinition* SpiceDefinition::find_definition(std::string_view wanted) const {
  const auto found = std::find_if(
      definitions.begin(), definitions.end(),
      [&](const SpiceDefinition& d) { return lower_spice(d.name) == lower_spice(wanted); });
  return found == definitions.end() ? nullptr : &*found;
}

const SpiceModel* SpiceDefinition::find_model(std::string_view wanted) const {
  const auto found = std::find_if(models.begin(), models.end(), [&](const SpiceModel& m) {
    return lower_spice(m.name) == lower_spice(wanted);
  });
  return found == models.end() ? nullptr : &*found;
}

SpiceDeck parse_spice_deck(std::string_view text, const std::filesystem::path& file) {
  Inclusion inclusion;
  inclusion.add(decode_spice_text(text, file.string()), file, SpiceFirstLine::title);
  return {DeckParser(inclusion.lines).parse(file.string()), inclusion.missing_libraries};
}

SpiceDeck read_spice_deck(const std::filesystem::path& path) {
  return parse_spice_deck(read_file(path), path);
}

std::vector<fs::path> find_spice_files(const fs::path& path) {
  Inclusion inclusion;
  inclusion.add(decode_spice_text(read_file(path), path.string()), path, SpiceFirstLine::title);
  std::vector<fs::path> files{path};
  for (const fs::path& file : inclusion.included)
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
  return files;
}

const SpiceDefinition& built_in_spice_library() {
  static const SpiceDefinition library = [] {
    SpiceDefinition top = parse_spice_deck(built_in_text, "built-in").top;
    for (SpiceDefinition& definition : top.definitions) definition.built_in = true;
    return top;
  }();
  return library;
}

}  // namespace gyrator

#include "gyrator/core/error.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/studies/schematic.hpp"

#include <memory>
#include <string>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  std::string model, output, svg;
  bool quiet = false;
};

void run(const Options& options) {
  const std::string name = options.svg.empty() ? "--output" : "--svg";
  const std::string& path = options.svg.empty() ? options.output : options.svg;
  if (!path.empty() && !path.ends_with(".svg"))
    throw Error(ErrorCode::bad_input, name, path + ": the name must end in .svg");
  check_files({{"the model", options.model}}, {{name, path}});
  const Schematic schematic = draw_schematic(load_model(options.model));
  if (path.empty()) {
    fmt::print("{}", schematic.svg);
    return;
  }
  write_text_file(path, schematic.svg);
  if (!options.quiet) fmt::print("{}\n", path);
}

}  // namespace

void add_schematic_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("schematic",
                         "The device drawn as a schematic (SVG): circuits, mechanics, "
                         "feedbacks and the sampled side, with their values");
  command->add_option("MODEL", options->model, "Model file (JSON)")->required()->check(not_empty());
  auto* output = command->add_option("-o,--output", options->output,
                                     "The picture to write; none: printed on stdout");
  output->type_name("FILE")->check(not_empty());
  command->add_option("--svg", options->svg, "The same as --output")
      ->type_name("FILE")
      ->check(not_empty())
      ->excludes(output);
  command->add_flag("--quiet", options->quiet, "Do not print the file's name");
  command->footer("Example:\n  gyrator schematic examples/rc_display.json -o schematic.svg");
  command->callback([options] { run(*options); });
}

}  // namespace gyrator::app

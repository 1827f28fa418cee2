#include "gyrator/amplifiers/device_profile.hpp"
#include "gyrator/documents/document_manual.hpp"
#include "gyrator/documents/document_schema.hpp"
#include "gyrator/regression/regression_study.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/sweeps/sweep_study.hpp"
#include "gyrator/synthesis/design_spec.hpp"

#include <memory>

#include <fmt/core.h>

#include "commands.hpp"

namespace gyrator::app {

void add_schema_command(CLI::App& app, int&) {
  auto manual = std::make_shared<bool>(false);
  auto study = std::make_shared<bool>(false);
  auto amplifier = std::make_shared<bool>(false);
  auto design = std::make_shared<bool>(false);
  auto regression = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("schema", "The model file's JSON Schema, for completion in editors");
  auto* of_study =
      command->add_flag("--study", *study, "Of the study file (`gyrator study run`) instead");
  auto* of_amplifier =
      command->add_flag("--amplifier", *amplifier, "Of the amplifier's profile instead")
          ->excludes(of_study);
  auto* of_design =
      command->add_flag("--design", *design, "Of the design's spec (`gyrator design`) instead")
          ->excludes(of_study)
          ->excludes(of_amplifier);
  command
      ->add_flag("--regression", *regression,
                 "Of the regression study (`gyrator study check`) instead")
      ->excludes(of_study)
      ->excludes(of_amplifier)
      ->excludes(of_design);
  command->add_flag("--manual", *manual, "The same as tables in Markdown");
  command->footer("Example:\n  gyrator schema > model.schema.json");
  command->callback([manual, study, amplifier, design, regression] {
    const Member& format = *study        ? study_format()
                           : *amplifier  ? amplifier_format()
                           : *design     ? design_format()
                           : *regression ? regression_format()
                                         : model_format();
    const char* name = *study        ? "study"
                       : *amplifier  ? "amplifier"
                       : *design     ? "design"
                       : *regression ? "regression"
                                     : "model";
    const std::string id = fmt::format("https://gyrator.example/{}.schema.json", name);
    fmt::print("{}", *manual ? write_manual_table(format) : write_json_schema(format, id));
  });
}

}  // namespace gyrator::app

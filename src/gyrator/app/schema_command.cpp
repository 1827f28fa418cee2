#include "gyrator/documents/document_manual.hpp"
#include "gyrator/documents/document_schema.hpp"
#include "gyrator/studies/model_format.hpp"

#include <memory>

#include <fmt/core.h>

#include "commands.hpp"

namespace gyrator::app {

void add_schema_command(CLI::App& app, int&) {
  auto manual = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("schema", "The model file's JSON Schema, for completion in editors");
  command->add_flag("--manual", *manual, "The same as tables in Markdown");
  command->footer("Example:\n  gyrator schema > model.schema.json");
  command->callback([manual] {
    fmt::print("{}", *manual ? write_manual_table(model_format())
                             : write_json_schema(model_format(),
                                                 "https://gyrator.example/model.schema.json"));
  });
}

}  // namespace gyrator::app

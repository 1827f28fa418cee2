#include "gyrator/documents/document_kind.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <array>

#include <fmt/core.h>

namespace gyrator {
namespace {

struct Kind {
  std::string_view prefix, name, reader;
};
constexpr std::array kinds{
    Kind{"gyrator/model/", "a model", "`gyrator passivity`"},
    Kind{"gyrator/design/", "a design spec", "`gyrator design`"},
    Kind{"gyrator/study/", "a sweep", "`gyrator study run`"},
    Kind{"gyrator/regression/", "a regression study", "`gyrator study check`"},
    Kind{"gyrator/amplifier/", "an amplifier's profile", "--profile"},
    Kind{"gyrator/backup/", "a backup of an amplifier", "`gyrator restore`"},
};

const Kind* kind_of(std::string_view schema) {
  const auto* found = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& kind) {
    return schema.starts_with(kind.prefix);
  });
  return found == kinds.end() ? nullptr : found;
}

}  // namespace

void check_document_kind(const nlohmann::json& document, std::string_view expected,
                         const std::string& file) {
  if (!document.is_object()) return;
  const auto schema = document.find("schema");
  if (schema == document.end() || !schema->is_string()) return;
  const auto text = schema->get<std::string>();
  const Kind* found = kind_of(text);
  const Kind* wanted = kind_of(expected);
  if (!found || !wanted || found == wanted) return;
  throw Error(ErrorCode::bad_input, file + ": /schema",
              fmt::format("'{}': this is {}, which {} reads: {} (\"{}\") is expected", text,
                          found->name, found->reader, wanted->name, expected));
}

}  // namespace gyrator

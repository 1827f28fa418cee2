#include "gyrator/documents/document_kind.hpp"

#include "gyrator/core/error.hpp"

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

TEST(DocumentKind, NamesBothKindsAndTheCommandThatReadsTheFile) {
  try {
    check_document_kind({{"schema", "gyrator/design/1"}}, "gyrator/model/1", "spec.json");
    FAIL() << "a design spec was taken for a model";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_STREQ(error.what(),
                 "spec.json: /schema: 'gyrator/design/1': this is a design spec, which `gyrator "
                 "design` reads: a model (\"gyrator/model/1\") is expected");
  }
}

TEST(DocumentKind, LeavesToTheReaderWhatItDoesNotKnow) {
  for (const json& document :
       {json{{"schema", "gyrator/model/1"}}, json{{"schema", "gyrator/model/2"}},
        json{{"schema", "something/1"}}, json{{"schema", 1}}, json::object(), json::array()})
    EXPECT_NO_THROW(check_document_kind(document, "gyrator/model/1", "model.json")) << document;
}

}  // namespace
}  // namespace gyrator

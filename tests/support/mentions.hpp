#pragma once

#include <string>

#include <gtest/gtest.h>

namespace gyrator::passivity_tests {

inline testing::AssertionResult mentions(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << '"' << text << "\" does not mention \"" << part << '"';
}

}  // namespace gyrator::passivity_tests

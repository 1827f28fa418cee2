#include "gyrator/core/error.hpp"

#include <utility>

namespace gyrator {

Error::Error(ErrorCode code, std::string place, std::string message)
    : std::runtime_error(place.empty() ? message : place + ": " + message),
      code_(code),
      place_(std::move(place)),
      message_(std::move(message)) {}

}  // namespace gyrator

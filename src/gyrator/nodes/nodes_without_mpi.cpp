// What takes the place of nodes.cpp where no MPI was found at configure time.

#include "gyrator/core/error.hpp"
#include "gyrator/nodes/nodes.hpp"

#include <cstdlib>

namespace gyrator {

bool is_one_of_many() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): read before any thread
    if (text != nullptr && std::strtol(text, nullptr, 10) > 1) return true;
  }
  return false;
}

Nodes::Nodes() {
  throw Error(ErrorCode::bad_input, "MPI",
              "this program was built without it: start it without mpirun, or build it where MPI "
              "is found (libopenmpi-dev)");
}
Nodes::~Nodes() = default;
int Nodes::find_largest(int value) {
  return value;
}
void Nodes::send(int, std::string_view) {}
std::optional<Nodes::Message> Nodes::poll() {
  return std::nullopt;
}
Nodes::Message Nodes::wait() {
  return {};
}
void Nodes::finish() {}

}  // namespace gyrator

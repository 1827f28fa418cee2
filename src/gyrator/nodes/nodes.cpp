#include "gyrator/nodes/nodes.hpp"

#include "gyrator/core/error.hpp"

#include <chrono>
#include <cstdlib>
#include <mpi.h>
#include <thread>

namespace gyrator {
namespace {

constexpr int message_tag = 1;
constexpr int failure_code = 3;  // of all processes where one fails without a word
// Far shorter than a chunk of work, far longer than a look at the queue (a microsecond).
constexpr auto nap = std::chrono::microseconds(200);

// The number in a variable of the environment; none without one.
std::optional<long> find_count(const char* name) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): read before any thread
  if (text == nullptr) return std::nullopt;
  return std::strtol(text, nullptr, 10);
}

}  // namespace

bool is_one_of_many() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    if (const auto count = find_count(name)) return *count > 1;
  }
  return find_count("PMIX_RANK").has_value();  // the size is not told
}

Nodes::Nodes() {
  int provided = 0;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS ||
      provided < MPI_THREAD_FUNNELED)
    throw Error(ErrorCode::device, "MPI", "could not be started with threads beside it");
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
}

Nodes::~Nodes() {
  if (!finished_) MPI_Abort(MPI_COMM_WORLD, failure_code);
}

// MPI keeps its own state; that an object is there says that it was started.
// NOLINTBEGIN(readability-convert-member-functions-to-static)

int Nodes::find_largest(int value) {
  int largest = value;
  MPI_Allreduce(&value, &largest, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return largest;
}

void Nodes::send(int to, std::string_view bytes) {
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, message_tag, MPI_COMM_WORLD);
}

std::optional<Nodes::Message> Nodes::poll() {
  int there = 0;
  MPI_Status status{};
  MPI_Iprobe(MPI_ANY_SOURCE, message_tag, MPI_COMM_WORLD, &there, &status);
  if (there == 0) return std::nullopt;
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(size), '\0')};
  MPI_Recv(message.bytes.data(), size, MPI_BYTE, message.from, message_tag, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  return message;
}

// NOLINTEND(readability-convert-member-functions-to-static)

Nodes::Message Nodes::wait() {
  for (;;) {
    if (auto message = poll()) return std::move(*message);
    std::this_thread::sleep_for(nap);
  }
}

void Nodes::finish() {
  if (finished_) return;
  finished_ = true;
  MPI_Finalize();
}

}  // namespace gyrator

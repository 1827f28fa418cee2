#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace gyrator {

/// Whether mpirun, or srun with PMI, started this process as one of several: by its environment,
/// so that nothing of MPI is paid for otherwise.
bool is_one_of_many();

/// The processes of one program that mpirun started: MPI from construction to finish().
///
/// Only the thread that made it may use it (MPI_THREAD_FUNNELED); others may compute meanwhile.
/// Destroyed without finish(), because an error is on its way that the others do not know of, it
/// ends them all. Throws bad_input where the program was built without MPI.
class Nodes {
 public:
  Nodes();
  ~Nodes();

  Nodes(const Nodes&) = delete;
  Nodes& operator=(const Nodes&) = delete;
  Nodes(Nodes&&) = delete;
  Nodes& operator=(Nodes&&) = delete;

  int rank() const { return rank_; }    ///< from 0
  int count() const { return count_; }  ///< of processes

  /// The largest of the values that the processes pass; waits until all have called it.
  int find_largest(int value);

  void send(int to, std::string_view bytes);

  struct Message {
    int from = 0;
    std::string bytes;
  };
  /// The next message, if one is there.
  std::optional<Message> poll();
  /// The next message. Sleeps between its looks, so that the core is free for others.
  Message wait();

  /// The regular end, for all processes: none has anything to say any more.
  void finish();

 private:
  int rank_ = 0;
  int count_ = 1;
  bool finished_ = false;
};

}  // namespace gyrator

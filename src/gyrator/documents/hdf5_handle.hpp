#pragma once

#include <hdf5.h>
#include <utility>

namespace gyrator {

/// Owns one identifier of the HDF5 library; `closer` is what the library wants called for its kind:
///     const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
/// An identifier that could not be had is negative, and is not closed.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Hdf5Handle(hid_t id, Close closer) : id_(id), close_(closer) {}
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(Hdf5Handle&&) = delete;

  /// Before its time, to know whether that went well: negative if not.
  herr_t close() { return close_(std::exchange(id_, -1)); }

  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  Close close_;
};

}  // namespace gyrator

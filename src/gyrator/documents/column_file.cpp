#include "gyrator/documents/column_file.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/hdf5_handle.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>

#include <fmt/core.h>

namespace gyrator {
namespace {

// What the library says of its own errors goes to stderr unless it is told not to.
void silence_library() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

hid_t checked(hid_t id, const char* what) {
  if (id < 0) throw Error(ErrorCode::numerical, "HDF5", fmt::format("{} failed", what));
  return id;
}

Hdf5Handle make_text_type() {
  Hdf5Handle type(checked(H5Tcopy(H5T_C_S1), "a text type"), H5Tclose);
  checked(H5Tset_size(type.get(), H5T_VARIABLE), "a text type");
  checked(H5Tset_cset(type.get(), H5T_CSET_UTF8), "a text type");
  return type;
}

void write_attribute(hid_t owner, const std::string& name, const ColumnFile::Attribute& value) {
  const Hdf5Handle space(checked(H5Screate(H5S_SCALAR), "an attribute"), H5Sclose);
  if (const auto* number = std::get_if<std::int64_t>(&value)) {
    const Hdf5Handle attribute(checked(H5Acreate2(owner, name.c_str(), H5T_STD_I64LE, space.get(),
                                                  H5P_DEFAULT, H5P_DEFAULT),
                                       "an attribute"),
                               H5Aclose);
    checked(H5Awrite(attribute.get(), H5T_NATIVE_INT64, number), "an attribute");
    return;
  }
  // Of the text's own length: many readers know no other attributes than these.
  const auto& text = std::get<std::string>(value);
  const Hdf5Handle type(checked(H5Tcopy(H5T_C_S1), "a text type"), H5Tclose);
  checked(H5Tset_size(type.get(), std::max<std::size_t>(1, text.size())), "a text type");
  checked(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "a text type");
  checked(H5Tset_cset(type.get(), H5T_CSET_UTF8), "a text type");
  const Hdf5Handle attribute(
      checked(H5Acreate2(owner, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
              "an attribute"),
      H5Aclose);
  checked(H5Awrite(attribute.get(), type.get(), text.empty() ? "\0" : text.data()), "an attribute");
}

struct ColumnType {
  hid_t stored, in_memory;
};

void write_values(hid_t dataset, hid_t type, const Column::Values& values) {
  const auto write = [&](const void* data) {
    checked(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "writing a column");
  };
  if (const auto* numbers = std::get_if<std::vector<double>>(&values))
    return write(numbers->data());
  if (const auto* codes = std::get_if<std::vector<std::int32_t>>(&values))
    return write(codes->data());
  // An empty text needs no place in the file's heap: most columns of texts are nearly empty.
  std::vector<const char*> texts;
  for (const std::string& text : std::get<std::vector<std::string>>(values))
    texts.push_back(text.empty() ? nullptr : text.c_str());
  write(texts.data());
}

void write_column(hid_t file, const Column& column) {
  const Hdf5Handle text = make_text_type();
  const std::array<ColumnType, 3> types{{{H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE},
                                         {H5T_STD_I32LE, H5T_NATIVE_INT32},
                                         {text.get(), text.get()}}};
  const ColumnType& type = types.at(column.values.index());
  const hsize_t length = column.size();
  const Hdf5Handle space(checked(H5Screate_simple(1, &length, nullptr), "a column"), H5Sclose);
  const Hdf5Handle properties(checked(H5Pcreate(H5P_DATASET_CREATE), "a column"), H5Pclose);
  checked(H5Pset_obj_track_times(properties.get(), false), "a column");
  checked(H5Pset_attr_creation_order(properties.get(), H5P_CRT_ORDER_TRACKED), "a column");
  const Hdf5Handle dataset(checked(H5Dcreate2(file, column.name.c_str(), type.stored, space.get(),
                                              H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                                   "a column"),
                           H5Dclose);
  if (length > 0) write_values(dataset.get(), type.in_memory, column.values);
  for (const auto& [name, value] : column.attributes) write_attribute(dataset.get(), name, value);
}

Hdf5Handle create_file(const std::string& path) {
  const Hdf5Handle access(checked(H5Pcreate(H5P_FILE_ACCESS), "a file"), H5Pclose);
  checked(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18), "a file");
  const Hdf5Handle creation(checked(H5Pcreate(H5P_FILE_CREATE), "a file"), H5Pclose);
  const unsigned ordered = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
  checked(H5Pset_link_creation_order(creation.get(), ordered), "a file");
  checked(H5Pset_attr_creation_order(creation.get(), ordered), "a file");
  checked(H5Pset_obj_track_times(creation.get(), false), "a file");
  // Attributes stand in a heap, for a model's text may be longer than an object's header.
  checked(H5Pset_attr_phase_change(creation.get(), 0, 0), "a file");
  return {checked(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), "a file"),
          H5Fclose};
}

std::string read_fixed_text(hid_t attribute, hid_t type) {
  std::string text(H5Tget_size(type), '\0');
  if (H5Aread(attribute, type, text.data()) < 0) return {};
  return text.substr(0, text.find('\0'));
}

std::optional<ColumnFile::Attribute> read_attribute(hid_t attribute) {
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  if (H5Tget_class(type.get()) == H5T_STRING && H5Tis_variable_str(type.get()) <= 0)
    return read_fixed_text(attribute, type.get());
  if (H5Tget_class(type.get()) != H5T_INTEGER) return std::nullopt;
  std::int64_t number = 0;
  if (H5Aread(attribute, H5T_NATIVE_INT64, &number) < 0) return std::nullopt;
  return number;
}

// In order of creation where the object kept it, else by name.
template <class Take>
void read_attributes(hid_t owner, const Take& take) {
  H5O_info_t info{};
  if (H5Oget_info(owner, &info) < 0) return;
  for (hsize_t i = 0; i < info.num_attrs; ++i) {
    const Hdf5Handle attribute(
        H5Aopen_by_idx(owner, ".", H5_INDEX_CRT_ORDER, H5_ITER_INC, i, H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    if (!attribute) continue;
    const auto length = H5Aget_name(attribute.get(), 0, nullptr);
    std::string name(static_cast<std::size_t>(std::max<ssize_t>(0, length)) + 1, '\0');
    H5Aget_name(attribute.get(), name.size(), name.data());
    name.pop_back();
    if (auto value = read_attribute(attribute.get())) take(name, std::move(*value));
  }
}

template <class T>
std::optional<Column::Values> read_numbers(hid_t dataset, hid_t type, std::size_t length) {
  std::vector<T> values(length);
  if (length > 0 && H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    return std::nullopt;
  return values;
}

std::optional<Column::Values> read_texts(hid_t dataset, hid_t space, std::size_t length) {
  const Hdf5Handle type = make_text_type();
  std::vector<char*> raw(length, nullptr);
  if (length > 0 && H5Dread(dataset, type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, raw.data()) < 0)
    return std::nullopt;
  std::vector<std::string> texts;
  texts.reserve(length);
  for (const char* text : raw) texts.emplace_back(text == nullptr ? "" : text);
  H5Dvlen_reclaim(type.get(), space, H5P_DEFAULT, raw.data());
  return texts;
}

std::optional<Column::Values> read_values(hid_t dataset) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  if (H5Sget_simple_extent_ndims(space.get()) != 1) return std::nullopt;
  const auto length = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get()));
  switch (H5Tget_class(type.get())) {
    case H5T_FLOAT:
      return read_numbers<double>(dataset, H5T_NATIVE_DOUBLE, length);
    case H5T_INTEGER:
      return read_numbers<std::int32_t>(dataset, H5T_NATIVE_INT32, length);
    case H5T_STRING:
      if (H5Tis_variable_str(type.get()) > 0) return read_texts(dataset, space.get(), length);
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

std::optional<Column> read_column(hid_t file, hsize_t index) {
  const auto length = H5Lget_name_by_idx(file, ".", H5_INDEX_CRT_ORDER, H5_ITER_INC, index, nullptr,
                                         0, H5P_DEFAULT);
  if (length < 0) return std::nullopt;
  Column column;
  column.name.resize(static_cast<std::size_t>(length) + 1);
  H5Lget_name_by_idx(file, ".", H5_INDEX_CRT_ORDER, H5_ITER_INC, index, column.name.data(),
                     column.name.size(), H5P_DEFAULT);
  column.name.pop_back();
  const Hdf5Handle dataset(H5Dopen2(file, column.name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset) return std::nullopt;
  auto values = read_values(dataset.get());
  if (!values) return std::nullopt;
  column.values = std::move(*values);
  read_attributes(dataset.get(), [&](const std::string& name, ColumnFile::Attribute value) {
    if (auto* text = std::get_if<std::string>(&value))
      column.attributes.emplace_back(name, std::move(*text));
  });
  return column;
}

}  // namespace

std::size_t Column::size() const {
  return std::visit([](const auto& v) { return v.size(); }, values);
}

std::string Column::attribute(std::string_view key) const {
  for (const auto& [given, value] : attributes)
    if (given == key) return value;
  return {};
}

const Column* ColumnFile::find(std::string_view name) const {
  for (const Column& column : columns)
    if (column.name == name) return &column;
  return nullptr;
}

std::string ColumnFile::attribute(std::string_view key) const {
  for (const auto& [name, value] : attributes) {
    const auto* text = std::get_if<std::string>(&value);
    if (name == key && text != nullptr) return *text;
  }
  return {};
}

void write_hdf5(const std::string& path, const ColumnFile& file, Durability durability) {
  silence_library();
  OutputFile output(path);
  if (output.temporary().empty()) {
    throw Error(ErrorCode::bad_input, path,
                "is no ordinary file: an HDF5 file cannot be written in one stream");
  }
  try {
    Hdf5Handle handle = create_file(output.temporary().string());
    for (const auto& [name, value] : file.attributes) write_attribute(handle.get(), name, value);
    for (const Column& column : file.columns) write_column(handle.get(), column);
    // What is still in memory shows only now whether there is room for it.
    checked(handle.close(), "a file");
  } catch (const Error& error) {
    throw Error(ErrorCode::bad_input, path, "cannot be written: HDF5: " + error.message());
  }
  output.commit(durability);
}

ColumnFile read_hdf5(const std::string& path) {
  silence_library();
  if (!std::ifstream(path, std::ios::binary)) {
    throw Error(ErrorCode::bad_input, path,
                fmt::format("cannot be read: {}", std::strerror(errno != 0 ? errno : EIO)));
  }
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file) throw Error(ErrorCode::bad_input, path, "is no HDF5 file, or a damaged one");
  ColumnFile result;
  read_attributes(file.get(), [&](const std::string& name, ColumnFile::Attribute value) {
    result.attributes.emplace_back(name, std::move(value));
  });
  H5G_info_t group{};
  if (H5Gget_info(file.get(), &group) < 0) return result;
  for (hsize_t i = 0; i < group.nlinks; ++i) {
    if (auto column = read_column(file.get(), i)) result.columns.push_back(std::move(*column));
  }
  return result;
}

}  // namespace gyrator

#include "gyrator/sweeps/sweep_plan.hpp"

#include "gyrator/circuits/spice_reader.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/random_stream.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/digest.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/version.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include <boost/random/sobol.hpp>
#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr std::size_t most_points = 100'000'000;

// What is read besides the model: a netlist with all that it includes, or a recording.
struct NamedFile {
  std::string name;  // as the model names it
  bool is_netlist = false;
};

// Of a damping or of an operator; recordings have columns instead.
bool is_netlist(const json& owner) {
  return owner.is_object() && owner.contains("subckt");
}

// Netlists and recordings, wherever in the model they are named; what cannot be read is refused
// when the model is built.
void collect_files(const json& value, std::vector<NamedFile>& files) {
  if (!value.is_structured()) return;
  for (const auto& [key, inner] : value.items()) {
    if (key == "file" && inner.is_string()) files.push_back({inner, is_netlist(value)});
    collect_files(inner, files);
  }
}

std::vector<std::filesystem::path> find_read_files(const std::filesystem::path& path,
                                                   bool is_netlist) {
  if (!is_netlist) return {path};
  try {
    return find_spice_files(path);
  } catch (const Error&) {  // refused when the model is built
    return {path};
  }
}

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void check_paths(const std::vector<Variation>& variations) {
  for (std::size_t i = 0; i < variations.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (variations[i].pointer() != variations[j].pointer()) continue;
      throw Error(ErrorCode::bad_input, variations[i].text().place, "varies twice");
    }
  }
}

}  // namespace

SweepPlan::SweepPlan(SweepStudy study)
    : study_(std::move(study)),
      analysis_(&find_sweep_analysis(study_.analysis, "--analysis")),
      normal_(read_document(parse_json_text(study_.model_text, study_.model_file), model_format(),
                            study_.model_file)),
      outputs_(analysis_->outputs(normal_["motion"] == "rotary" ? Motion::rotary : Motion::linear)),
      model_sha256_(compute_sha256(study_.model_text)) {
  for (const VariationText& text : study_.vary)
    variations_.emplace_back(text, normal_, model_format());
  if (variations_.empty())
    throw Error(ErrorCode::bad_input, "--vary", "nothing varies: give at least one");
  check_paths(variations_);
  size_ = count_points();
  if (study_.sampling == SamplingKind::sobol) draw_sobol();
  identity_ = identify();
}

std::string SweepPlan::model_name() const {
  return normal_["name"];
}

std::size_t SweepPlan::count_points() const {
  if (study_.sampling != SamplingKind::grid) return study_.samples;
  std::size_t count = 1;
  for (const Variation& variation : variations_) {
    count *= variation.count_grid_points();
    if (count > most_points) {
      throw Error(ErrorCode::bad_input, variation.text().place,
                  fmt::format("the grid has more than {} points, the most allowed: sample it with "
                              "--sobol or --random",
                              most_points));
    }
  }
  return count;
}

void SweepPlan::draw_sobol() {
  const std::size_t dimensions = variations_.size();
  boost::random::sobol sequence(dimensions);
  shares_.reserve(size_ * dimensions);
  for (std::size_t i = 0; i < size_ * dimensions; ++i)
    shares_.push_back(static_cast<double>(sequence() >> 11U) * 0x1p-53);
}

std::vector<SweepValue> SweepPlan::values_at(std::size_t point) const {
  const std::size_t count = variations_.size();
  std::vector<SweepValue> values(count);
  if (study_.sampling == SamplingKind::grid) {
    for (std::size_t p = count; p-- > 0;) {  // the last digit first
      const std::size_t n = variations_[p].count_grid_points();
      values[p] = variations_[p].at_grid(point % n);
      point /= n;
    }
    return values;
  }
  RandomStream random(study_.seed, point);
  const bool is_random = study_.sampling == SamplingKind::random;
  for (std::size_t p = 0; p < count; ++p)
    values[p] = variations_[p].at_share(is_random ? random.uniform() : shares_[point * count + p]);
  return values;
}

json SweepPlan::document_at(std::size_t point) const {
  json document = normal_;
  const auto values = values_at(point);
  for (std::size_t p = 0; p < values.size(); ++p)
    document[variations_[p].pointer()] = values[p].given;
  return document;
}

std::string SweepPlan::describe_point(std::size_t point) const {
  const auto values = values_at(point);
  std::vector<std::string> parts;
  for (std::size_t p = 0; p < values.size(); ++p) {
    const std::string unit = variations_[p].unit();
    parts.push_back(
        fmt::format("{} = {}{}", variations_[p].path(),
                    variations_[p].is_number() ? format_number(values[p].number) : values[p].text,
                    unit.empty() || unit == "1" ? "" : " " + unit));
  }
  return join(parts);
}

json SweepPlan::identify() const {
  json files = json::object();
  std::vector<NamedFile> named;
  collect_files(normal_, named);
  for (const Variation& variation : variations_) {
    if (variation.pointer().back() != "file") continue;
    const bool netlist = is_netlist(normal_[variation.pointer().parent_pointer()]);
    for (const json& value : variation.text().values)
      if (value.is_string()) named.push_back({value, netlist});
  }
  const auto folder = std::filesystem::path(study_.model_file).parent_path();
  for (const NamedFile& file : named) {
    const auto read = find_read_files(folder / file.name, file.is_netlist);
    files[file.name] = compute_sha256(read_bytes(read.front()));
    for (std::size_t i = 1; i < read.size(); ++i) {  // where its includes begin, on any machine
      const auto beside = folder.empty() ? read[i] : read[i].lexically_relative(folder);
      files[(beside.empty() ? read[i] : beside).string()] = compute_sha256(read_bytes(read[i]));
    }
  }
  return {{"program", fmt::format("gyrator {}", version)},
          {"study", describe_study(study_)},
          {"model_sha256", model_sha256_},
          {"files", std::move(files)}};
}

std::string SweepPlan::digest() const {
  return compute_sha256(identity_.dump(-1, ' ', false, json::error_handler_t::replace));
}

}  // namespace gyrator

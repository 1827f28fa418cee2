#pragma once

#include "gyrator/sweeps/sweep_analyses.hpp"
#include "gyrator/sweeps/sweep_study.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// A study with its model read and its points laid out; const and shared by all who compute.
///   grid     point i has the index k_p of each variation p as the digits of i, the last variation
///            changing fastest                                                      (sweep-4)
///   sobol    point i is the i-th of the Sobol sequence of as many dimensions as there are
///            variations, each a share u in [0, 1); it begins with 1/2 in all (Boost.Random,
///            directions by Joe and Kuo)                                            (sweep-5)
///   random   point i has the first shares u of the random stream (seed, i), in the order of the
///            variations                                                            (sweep-6)
class SweepPlan {
 public:
  /// Throws bad_input for what is not as it must be, before anything is computed.
  explicit SweepPlan(SweepStudy study);

  const SweepStudy& study() const { return study_; }
  const SweepAnalysis& analysis() const { return *analysis_; }
  const std::vector<SweepOutput>& outputs() const { return outputs_; }
  const std::vector<Variation>& variations() const { return variations_; }
  std::string model_name() const;

  std::size_t size() const { return size_; }  ///< number of points
  std::vector<SweepValue> values_at(std::size_t point) const;
  /// The model with these values, in normal form.
  nlohmann::json document_at(std::size_t point) const;
  /// "damping.0.capacitance = 0.0001 F, controller.stiffness = 0.2 N.m/rad"
  std::string describe_point(std::size_t point) const;

  const std::string& model_sha256() const { return model_sha256_; }
  /// What decides every number of the result: program, study, model, and the files that it names
  /// and those include.
  const nlohmann::json& identity() const { return identity_; }
  /// SHA-256 of it.
  std::string digest() const;

 private:
  std::size_t count_points() const;
  void draw_sobol();
  nlohmann::json identify() const;

  SweepStudy study_;
  const SweepAnalysis* analysis_;
  nlohmann::json normal_;  // of the model
  std::vector<SweepOutput> outputs_;
  std::vector<Variation> variations_;
  std::size_t size_ = 0;
  std::vector<double> shares_;  // of sobol, point after point
  std::string model_sha256_;
  nlohmann::json identity_;
};

}  // namespace gyrator

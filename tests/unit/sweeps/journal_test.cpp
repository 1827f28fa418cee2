#include "gyrator/core/error.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/sweeps/sweep_journal.hpp"
#include "gyrator/sweeps/sweep_queue.hpp"
#include "gyrator/sweeps/sweep_result.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

SweepPlan plan_of(const std::string& vary) {
  SweepStudy study;
  study.file = study.model_file = "model.json";
  study.model_text =
      R"({"motion": "rotary", "name": "test", "mechanics": {"inertia": 2e-5, "damping": 1e-4},
    "amplifier": {"kind": "ideal"}, "sampling": {"period": "1 ms"},
    "controller": {"kind": "virtual_wall", "stiffness": 0.4, "damping": 1.5e-4}})";
  study.analysis = "zwidth";
  study.vary.push_back(parse_variation(vary));
  return SweepPlan(study);
}

SweepPlan twelve_points() {
  return plan_of("controller.stiffness=0.1..1.2:12");
}

// Numbers that only their bits tell apart: infinities, a rounded third, the smallest of all.
PointResult point(std::size_t i) {
  return {PointStatus::ok,
          {static_cast<double>(i) / 3, std::numeric_limits<double>::denorm_min(), HUGE_VAL},
          {}};
}

ChunkResult chunk(std::size_t first, std::size_t count) {
  ChunkResult result{first, {}, {}};
  for (std::size_t i = 0; i < count; ++i) result.points.push_back(point(first + i));
  return result;
}

class Journal : public ::testing::Test {
 protected:
  std::string path() const { return (folder_ / "sweep.h5.journal").string(); }

  // Opens it, adds chunks, and closes it without an end, as a crash does.
  void write(const SweepPlan& plan, const std::vector<ChunkResult>& chunks) const {
    SweepStore store(plan.size(), plan.outputs().size());
    SweepJournal journal(path(), plan, store, false);
    for (const auto& c : chunks) journal.append(c);
  }

  SweepStore read(const SweepPlan& plan, bool restart = false) const {
    SweepStore store(plan.size(), plan.outputs().size());
    SweepJournal journal(path(), plan, store, restart);
    return store;
  }

  ScratchFolder folder_;
};

TEST_F(Journal, gives_back_every_bit_of_what_was_put_in) {
  const SweepPlan plan = twelve_points();
  ChunkResult failed = chunk(8, 2);
  failed.points[1] = {PointStatus::timed_out, std::vector<double>(3, NAN), "not done within 1 s"};
  write(plan, {chunk(2, 3), failed});
  const SweepStore store = read(plan);
  for (const std::size_t i : {2, 3, 4, 8}) {
    ASSERT_EQ(store.status(i), PointStatus::ok);
    EXPECT_EQ(store.output(i, 0), static_cast<double>(i) / 3);
    EXPECT_EQ(store.output(i, 1), std::numeric_limits<double>::denorm_min());
    EXPECT_EQ(store.output(i, 2), HUGE_VAL);
  }
  EXPECT_EQ(store.status(9), PointStatus::timed_out);
  EXPECT_EQ(store.reason(9), "not done within 1 s");
  const auto missing = store.find_missing();
  ASSERT_EQ(missing.size(), 3U);
  EXPECT_EQ(missing[0].end(), 2U);
  EXPECT_EQ(missing[1].first, 5U);
  EXPECT_EQ(missing[1].count, 3U);
  EXPECT_EQ(missing[2].first, 10U);
}

TEST_F(Journal, drops_a_torn_last_record_wherever_it_was_torn) {
  const SweepPlan plan = twelve_points();
  write(plan, {chunk(0, 2)});
  const std::string one = read_text(path());
  write(plan, {chunk(2, 4)});
  const std::string two = read_text(path());
  ASSERT_GT(two.size(), one.size());
  for (std::size_t size = one.size(); size < two.size(); ++size) {
    write_text_file(path(), two.substr(0, size));
    EXPECT_EQ(read(plan).count().done(), 2U) << size;
    EXPECT_EQ(read_text(path()), one) << size;  // and it is gone
  }
  // Overwritten on the disk instead of cut off.
  std::string damaged = two;
  damaged[two.size() - 9] = static_cast<char>(damaged[two.size() - 9] ^ 1);
  write_text_file(path(), damaged);
  EXPECT_EQ(read(plan).count().done(), 2U);
}

TEST_F(Journal, begins_anew_where_not_even_its_head_was_written) {
  const SweepPlan plan = twelve_points();
  write(plan, {});
  const std::string head = read_text(path());
  for (const std::size_t size : {std::size_t{0}, std::size_t{2}, std::size_t{9}, head.size() - 1}) {
    write_text_file(path(), head.substr(0, size));
    EXPECT_EQ(read(plan).count().done(), 0U);
    EXPECT_EQ(read_text(path()), head);
  }
}

TEST_F(Journal, of_another_study_is_refused_with_what_is_different) {
  write(twelve_points(), {chunk(0, 2)});
  const std::string before = read_text(path());
  try {
    read(plan_of("controller.stiffness=0.1..1.3:12"));
    FAIL() << "a foreign journal was taken";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("other values vary"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("--restart"), std::string::npos);
  }
  EXPECT_EQ(read_text(path()), before);
  EXPECT_EQ(read(plan_of("controller.stiffness=0.1..1.3:12"), true).count().done(), 0U);
  EXPECT_NE(read_text(path()), before);
}

TEST_F(Journal, of_another_kind_of_file_is_left_alone) {
  write_text_file(path(), "notes of mine");
  for (const bool restart : {false, true}) {
    EXPECT_THROW(read(twelve_points(), restart), Error);
    EXPECT_EQ(read_text(path()), "notes of mine");
  }
}

TEST_F(Journal, can_be_read_without_its_model_and_study_files) {
  const SweepPlan plan = twelve_points();
  write(plan, {chunk(3, 2)});
  const SweepTable table = read_sweep(path());
  EXPECT_EQ(table.points, (std::vector<std::size_t>{3, 4}));
  EXPECT_EQ(table.size, 12U);
  const auto* stiffness = table.file.find("controller.stiffness");
  ASSERT_NE(stiffness, nullptr);
  EXPECT_EQ(std::get<std::vector<double>>(stiffness->values)[0], plan.values_at(3)[0].number);
}

TEST_F(Journal, and_result_hold_the_same_with_units) {
  const SweepPlan plan = twelve_points();
  SweepStore store(plan.size(), plan.outputs().size());
  ChunkResult all = chunk(0, 12);
  all.points[7] = {PointStatus::failed, std::vector<double>(3, NAN), "Ω is no number"};
  store.add(all);
  const std::string file = (folder_ / "sweep.h5").string();
  write_sweep_file(file, plan, store, "gyrator study run");
  const SweepTable table = read_sweep(file);
  ASSERT_EQ(table.file.columns.size(), 6U);
  EXPECT_EQ(table.file.columns[0].name, "controller.stiffness");
  EXPECT_EQ(table.file.columns[0].attribute("unit"), "N.m/rad");
  EXPECT_EQ(table.file.columns[2].name, "worst_frequency_hz");
  EXPECT_EQ(table.file.columns[2].attribute("unit"), "Hz");
  EXPECT_EQ(std::get<std::vector<double>>(table.file.columns[1].values)[5], 5.0 / 3);
  EXPECT_EQ(std::get<std::vector<std::int32_t>>(table.file.find("status")->values)[7], 1);
  EXPECT_EQ(std::get<std::vector<std::string>>(table.file.find("reason")->values)[7],
            "Ω is no number");
  EXPECT_EQ(table.file.attribute("command_line"), "gyrator study run");
  EXPECT_EQ(table.file.attribute("model_sha256"), plan.model_sha256());
  EXPECT_EQ(folder_.count(), 1U);
}

// The failing point lies in the upper half of the chunk, which another thread has begun with while
// the first has most of the lower half before it.
TEST(Chunk, a_failing_point_behind_points_that_were_never_begun_is_told) {
  SweepStudy study;
  study.file = study.model_file = "model.json";
  study.model_text =
      R"({"motion": "rotary", "name": "test", "mechanics": {"inertia": 2e-5, "damping": 1e-4},
    "motor": {"torque_constant": 0.05, "resistance": "1.5 ohm"}, "amplifier": {"kind": "voltage"},
    "damping": [{"kind": "resistance_cancellation", "fraction": 0.5}],
    "sampling": {"period": "1 ms"},
    "controller": {"kind": "virtual_wall", "stiffness": 0.4, "damping": 1.5e-4}})";
  study.analysis = "zwidth";
  std::string values = "damping.0.fraction=";
  for (int i = 0; i < 400; ++i) values += i == 200 ? "1.5," : "0.5,";
  study.vary.push_back(parse_variation(values + "0.5"));
  const SweepPlan plan(study);
  const ChunkResult result = compute_chunk(plan, {0, 401}, 2);
  ASSERT_TRUE(result.stopped_by);
  EXPECT_EQ(result.stopped_by->place(), "point 200 (damping.0.fraction = 1.5)");
  EXPECT_LE(result.points.size(), 200U);
  for (const PointResult& point : result.points) EXPECT_EQ(point.status, PointStatus::ok);
}

TEST(SweepQueue, hands_out_every_missing_point_once_and_smaller_chunks_towards_the_end) {
  SweepQueue queue({{0, 50}, {60, 40}}, 2);
  std::vector<int> taken(100, 0);
  std::size_t last = 100;
  while (const auto next = queue.take(1000)) {
    for (std::size_t i = next->first; i < next->end(); ++i) ++taken[i];
    last = next->count;
  }
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(taken[i], i >= 50 && i < 60 ? 0 : 1) << i;
  EXPECT_EQ(last, 1U);
}

TEST(SweepQueue, hands_out_nothing_once_it_is_stopped) {
  SweepQueue queue({{0, 50}}, 1);
  EXPECT_TRUE(queue.take(1));
  queue.stop();
  EXPECT_FALSE(queue.take(1));
}

}  // namespace
}  // namespace gyrator

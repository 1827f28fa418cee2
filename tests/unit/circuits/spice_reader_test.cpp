#include "gyrator/circuits/spice_reader.hpp"

#include <fstream>

#include "support/scratch_folder.hpp"
#include "unit/circuits/spice_bench.hpp"

namespace gyrator {
namespace {

SpiceDeck parse(std::string_view text) {
  return parse_spice_deck(text, "test.cir");
}

std::string refuse(std::string_view text) {
  return refusal([&] { parse(text); });
}

void write(const std::filesystem::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}

TEST(SpiceReader, statements_are_sorted_into_subcircuits) {
  const SpiceDeck deck = parse(
      "Title\n.param g=1\n.SUBCKT Outer a B params: r=1k c={2*r}\nR1 a b {r}\n.subckt inner x y\n"
      "C1 x y 1u\n.param h=2\n.ends inner\n.ENDS\nV1 a 0 1\n.end\nrubbish behind the end");
  EXPECT_EQ(deck.top.elements.size(), 1U);
  ASSERT_EQ(deck.top.definitions.size(), 1U);
  const SpiceDefinition& outer = deck.top.definitions[0];
  EXPECT_EQ(outer.name, "Outer");
  EXPECT_EQ(outer.place, "test.cir:3");
  EXPECT_EQ(outer.pins, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(outer.defaults.size(), 2U);
  EXPECT_EQ(outer.defaults[1].text, "{2*r}");
  EXPECT_EQ(outer.elements.size(), 1U);
  ASSERT_NE(outer.find_definition("INNER"), nullptr);
  EXPECT_EQ(outer.find_definition("INNER")->parameters.size(), 1U);
  EXPECT_EQ(deck.top.find_definition("inner"), nullptr) << "known inside of Outer only";
}

TEST(SpiceReader, control_lines_that_say_what_to_simulate_are_ignored) {
  const SpiceDeck deck = parse(
      "* c\n.tran 1u 1m\n.ac dec 10 1 1k\n.op\n.backanno\n.options gmin=0\n.save all\n.title x\n"
      ".control\nrun\nR9 what ever\nplot v(a)\n.endc\n.model D D\nR1 a 0 1\n");
  EXPECT_EQ(deck.top.elements.size(), 1U);
}

TEST(SpiceReader, other_control_lines_are_refused_with_the_nearest_one) {
  EXPECT_TRUE(mentions(refuse("* c\n.subcct s a b"),
                       {"test.cir:2: '.subcct s a b'", "did you mean '.subckt'?"}));
  EXPECT_TRUE(mentions(refuse("* c\n.ic v(a)=1"), {"test.cir:2", ".ic"}));
  EXPECT_TRUE(mentions(refuse("* c\n.func f(x) {x}"), {"test.cir:2", ".func"}));
}

TEST(SpiceReader, a_subcircuit_ends_once_and_by_its_name) {
  EXPECT_EQ(refuse("* c\n.subckt s a b\nR1 a b 1"), "test.cir:2: the subcircuit s has no .ends");
  EXPECT_EQ(refuse("* c\n.ends"), "test.cir:2: '.ends': no .subckt before it");
  EXPECT_EQ(refuse("* c\n.subckt s a b\n.ends t"),
            "test.cir:3: '.ends t' ends the subcircuit s of test.cir:2");
  EXPECT_EQ(refuse("* c\n.subckt S a b\n.ends\n.subckt s a b\n.ends"),
            "test.cir:4: the subcircuit s is defined a second time: first at test.cir:2");
}

TEST(SpiceReader, pins_are_distinct_and_not_ground) {
  EXPECT_TRUE(mentions(refuse(".subckt s a A\n.ends"), {"test.cir:1", "the pin A is there twice"}));
  EXPECT_TRUE(mentions(refuse(".subckt s a GND\n.ends"), {"test.cir:1", "GND is ground"}));
  EXPECT_TRUE(mentions(refuse(".subckt\n.ends"), {"needs a name"}));
}

TEST(SpiceReader, subcircuits_in_subcircuits_without_end_are_refused) {
  std::string text = "* c\n";
  for (int i = 0; i < 100; ++i) text += ".subckt s a b\n";
  EXPECT_TRUE(mentions(refuse(text), {"test.cir:34", "more than 32 deep"}));
}

TEST(SpiceReader, included_files_are_found_beside_the_including_one) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "parts");
  write(folder / "main.cir", "* c\n.include \"parts/a.lib\" ; comment\nX1 a 0 s\n");
  write(folder / "parts/a.lib", "R9 1 2 3\n.inc b.lib\n");
  write(folder / "parts/b.lib", ".subckt s a b\r\nR1 a b 1\r\n.ends\r\n.end\nrubbish");
  const SpiceDeck deck = read_spice_deck(folder / "main.cir");
  EXPECT_EQ(deck.top.elements.size(), 2U) << "an included file has no title to lose";
  ASSERT_NE(deck.top.find_definition("s"), nullptr);
  EXPECT_TRUE(mentions(deck.top.find_definition("s")->place, {"b.lib:1"}));
}

TEST(SpiceReader, a_file_that_is_included_twice_defines_once) {
  const ScratchFolder folder;
  write(folder / "main.cir", "* c\n.lib a.lib\n.lib a.lib\nX1 a 0 s\n");
  write(folder / "a.lib", ".subckt s a b\nR1 a b 1\n.ends\n.param x=1\n");
  EXPECT_EQ(read_spice_deck(folder / "main.cir").top.definitions.size(), 1U);
  EXPECT_EQ(read_subcircuit(folder / "main.cir", "s").elements.size(), 1U);
}

TEST(SpiceReader, a_circle_of_includes_and_a_deep_one_are_refused) {
  const ScratchFolder folder;
  write(folder / "main.cir", "* c\n.lib a.lib\n");
  write(folder / "a.lib", ".lib main.cir\n");
  EXPECT_TRUE(mentions(refusal([&] { read_spice_deck(folder / "main.cir"); }),
                       {"a.lib:1: '.lib main.cir'", "includes itself"}));
  write(folder / "a.lib", "* c\n.include a.lib\n");
  EXPECT_TRUE(mentions(refusal([&] { read_spice_deck(folder / "main.cir"); }),
                       {"a.lib:2", "includes itself"}));
  for (int i = 0; i < 40; ++i) {
    write(folder / ("d" + std::to_string(i)), ".inc d" + std::to_string(i + 1) + "\n");
  }
  write(folder / "main.cir", "* c\n.inc d0\n");
  EXPECT_TRUE(mentions(refusal([&] { read_spice_deck(folder / "main.cir"); }), {"16 deep"}));
}

TEST(SpiceReader, files_that_double_each_time_are_stopped) {
  const ScratchFolder folder;
  for (int i = 0; i < 12; ++i) {
    const std::string next = ".inc d" + std::to_string(i + 1) + "\n";
    write(folder / ("d" + std::to_string(i)), next + next + next + next);
  }
  write(folder / "d12", "* nothing\n");
  EXPECT_TRUE(mentions(refusal([&] { read_spice_deck(folder / "d0"); }), {"more than 1000 files"}));
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "R" + std::to_string(i) + " a b 1\n";
  write(folder / "d12", many);
  write(folder / "d8", ".inc d9\n");
  EXPECT_TRUE(mentions(refusal([&] { read_spice_deck(folder / "d8"); }),
                       {"d12:", "more than 20000 lines"}));
}

TEST(SpiceReader, a_missing_library_is_noted_and_a_missing_include_refused) {
  const SpiceDeck deck = parse("* c\n.lib C:\\LTspice lib\\cmp\\standard.dio\n");
  ASSERT_EQ(deck.missing_libraries.size(), 1U);
  EXPECT_EQ(deck.missing_libraries[0], "test.cir:2: C:\\LTspice lib\\cmp\\standard.dio");
  EXPECT_TRUE(
      mentions(refuse("* c\n.include nothing.lib"), {"test.cir:2", "nothing.lib", "not exist"}));
  EXPECT_TRUE(mentions(refuse("* c\n.lib \"a.lib\" fast"), {"test.cir:2", "sections"}));
  EXPECT_TRUE(mentions(refuse("* c\n.include"), {"a file name is missing"}));
  EXPECT_TRUE(mentions(refuse("* c\n.include \"a"), {"test.cir:2"}));
}

TEST(SpiceReader, a_file_that_cannot_be_read_is_named) {
  const ScratchFolder folder;
  EXPECT_TRUE(
      mentions(refusal([&] { read_spice_deck(folder / "no.cir"); }), {"no.cir: ", "exist"}));
  EXPECT_TRUE(mentions(refusal([&] { read_spice_deck(folder.path()); }), {"cannot be read"}));
}

}  // namespace
}  // namespace gyrator

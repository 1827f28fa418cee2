#include "gyrator/circuits/spice_lines.hpp"

#include <string>
#include <vector>

#include "unit/circuits/spice_bench.hpp"

namespace gyrator {
namespace {

using Strings = std::vector<std::string>;

std::string utf16(std::string_view ascii, bool big_endian) {
  std::string bytes;
  for (const char c : ascii) {
    if (big_endian) bytes += '\0';
    bytes += c;
    if (!big_endian) bytes += '\0';
  }
  return bytes;
}

Strings texts(const std::vector<SpiceLine>& lines) {
  Strings all;
  for (const SpiceLine& line : lines) all.push_back(line.text);
  return all;
}

Strings statements(std::string_view text) {
  return texts(split_spice_lines(text, "f", SpiceFirstLine::statement));
}

SpiceCard card(const std::string& text) {
  return parse_spice_card({"f:1", text});
}

TEST(SpiceLines, a_file_is_the_same_text_in_every_encoding) {
  const std::string text = "* c\nR1 a b 10u\n";
  EXPECT_EQ(decode_spice_text(text, "f"), text);
  EXPECT_EQ(decode_spice_text("\xEF\xBB\xBF" + text, "f"), text);
  EXPECT_EQ(decode_spice_text("\xFF\xFE" + utf16(text, false), "f"), text);
  EXPECT_EQ(decode_spice_text("\xFE\xFF" + utf16(text, true), "f"), text);
  EXPECT_EQ(decode_spice_text(utf16(text, false), "f"), text) << "LTspice writes no mark";
  EXPECT_EQ(decode_spice_text("* c\r\nR1 a b 10u\r", "f"), text);
}

TEST(SpiceLines, every_micro_sign_becomes_the_same_one) {
  const std::string micro = "1\u00B5";
  EXPECT_EQ(decode_spice_text("1\u00B5", "f"), micro);
  EXPECT_EQ(decode_spice_text("1\u03BC", "f"), micro);
  EXPECT_EQ(decode_spice_text("1\xB5", "f"), micro) << "Latin-1";
  EXPECT_EQ(decode_spice_text(std::string("\xFF\xFE") + "1" + '\0' + "\xB5" + '\0', "f"), micro);
  EXPECT_EQ(decode_spice_text(std::string("\xFF\xFE") + "1" + '\0' + "\xBC\x03", "f"), micro);
}

TEST(SpiceLines, characters_beyond_the_basic_plane_and_halves_of_pairs_are_decoded) {
  EXPECT_EQ(decode_spice_text(std::string("\xFF\xFE\x3D\xD8\x00\xDE", 6), "f"), "\U0001F600");
  EXPECT_EQ(decode_spice_text(std::string("\xFF\xFE\x3D\xD8"
                                          "a\0",
                                          6),
                              "f"),
            "\uFFFD"
            "a");
}

TEST(SpiceLines, a_binary_file_is_refused) {
  EXPECT_TRUE(mentions(refusal([] { decode_spice_text(std::string("ab\0c", 4), "f.cir"); }),
                       {"f.cir: ", "NUL"}));
}

TEST(SpiceLines, continuations_are_joined_and_comments_dropped) {
  EXPECT_EQ(
      statements("R1 a b 1k ; load\n* whole line\n+ tol=1 $ more\n\n C1 a$1 b 1u\n$ c\n ; d\n"),
      (Strings{"R1 a b 1k tol=1", "C1 a$1 b 1u"}));
  EXPECT_EQ(statements(".lib \"a;b.lib\" ; c"), (Strings{".lib \"a;b.lib\""}));
}

TEST(SpiceLines, a_statement_knows_its_first_line) {
  const auto lines =
      split_spice_lines("* c\n\nR1 a b\n+ 1k\nC1 a b 1u", "f", SpiceFirstLine::title);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].place, "f:3");
  EXPECT_EQ(lines[1].place, "f:5");
}

TEST(SpiceLines, a_continuation_of_nothing_is_refused) {
  EXPECT_EQ(refusal([] { statements("* c\n+ 1k"); }),
            "f:2: '+ 1k': '+' continues a line, and there is none before");
}

TEST(SpiceLines, a_deck_loses_its_title_and_nothing_else) {
  const auto deck = [](std::string_view text) {
    return texts(split_spice_lines(text, "f", SpiceFirstLine::title));
  };
  EXPECT_EQ(deck("Snubber of the motor\nR1 a b 1"), Strings{"R1 a b 1"});
  EXPECT_EQ(deck("\nR1 a b 1"), Strings{"R1 a b 1"});
  EXPECT_EQ(deck(".subckt s a b\nR1 a b 1"), (Strings{".subckt s a b", "R1 a b 1"}));
  EXPECT_EQ(deck("* c\nR1 a b 1"), Strings{"R1 a b 1"});
  EXPECT_EQ(statements("Ra 1 2 3"), Strings{"Ra 1 2 3"}) << "an included file has no title";
}

TEST(SpiceLines, an_element_in_the_place_of_the_title_is_refused_rather_than_lost) {
  const auto deck = [](std::string_view text) {
    return refusal([&] { split_spice_lines(text, "f", SpiceFirstLine::title); });
  };
  EXPECT_TRUE(mentions(deck("R1 a b 10k\nC1 a b 1u"), {"f:1: 'R1 a b 10k'", "title"}));
  EXPECT_TRUE(mentions(deck("c7 a b {x}"), {"title"}));
  EXPECT_EQ(deck("The snubber of 3"), "accepted");
}

TEST(SpiceLines, words_end_at_blanks_commas_and_lone_parentheses) {
  EXPECT_EQ(card("G1 a b (c, d)\t 2").words, (Strings{"G1", "a", "b", "c", "d", "2"}));
  EXPECT_EQ(card("R1 Net-(C1-Pad1) unconnected-(U1-Pad3) {a + f(b, c)}").words,
            (Strings{"R1", "Net-(C1-Pad1)", "unconnected-(U1-Pad3)", "{a + f(b, c)}"}));
  EXPECT_EQ(card("R1 /A{slash}B 0 'x + 1'").words, (Strings{"R1", "/A{slash}B", "0", "'x + 1'"}));
}

TEST(SpiceLines, assignments_stand_apart_with_names_in_lower_case) {
  const SpiceCard c = card("C1 a b 10u Rser = 0.1 LSER= {2 * n} V=25 params: x ='1 + 1'");
  EXPECT_EQ(c.words, (Strings{"C1", "a", "b", "10u"}));
  ASSERT_EQ(c.assignments.size(), 4U);
  EXPECT_EQ(c.assignments[0].name, "rser");
  EXPECT_EQ(c.assignments[0].value, "0.1");
  EXPECT_EQ(c.assignments[1].name, "lser");
  EXPECT_EQ(c.assignments[1].value, "{2 * n}");
  EXPECT_EQ(c.assignments[3].value, "'1 + 1'");
}

TEST(SpiceLines, what_has_no_end_or_no_name_is_refused_with_its_text) {
  EXPECT_EQ(refusal([] { card("R1 a b {1"); }), "f:1: 'R1 a b {1': a brace { has no end");
  EXPECT_EQ(refusal([] { card("R1 a b '1"); }), "f:1: 'R1 a b '1': a quote ' has no end");
  for (const char* text : {"R1 a b =", "=", "R1 = = 2", "R1 x ="}) {
    EXPECT_TRUE(mentions(refusal([&] { card(text); }), {"f:1", text, "'=' needs"}));
  }
}

TEST(SpiceLines, parameters_run_to_the_next_name) {
  const auto p = parse_spice_parameters(
      {"f:1", ".param A = 2 * b b=max(1, 2), c={x == 2 ? 1 : 3} d=(a >= b) e='1'"});
  ASSERT_EQ(p.size(), 5U);
  EXPECT_EQ(p[0].name, "a");
  EXPECT_EQ(p[0].value, "2 * b");
  EXPECT_EQ(p[1].value, "max(1, 2)");
  EXPECT_EQ(p[2].value, "{x == 2 ? 1 : 3}");
  EXPECT_EQ(p[3].value, "(a >= b)");
  EXPECT_EQ(p[4].name, "e");
}

TEST(SpiceLines, parameters_without_name_or_value_are_refused) {
  for (const char* text :
       {".param", ".param x", ".param = 3", ".param x=", ".param x= y=2", ".param 1+1 x=2"}) {
    EXPECT_TRUE(mentions(refusal([&] { parse_spice_parameters({"f:9", text}); }), {"f:9: ", text}));
  }
}

}  // namespace
}  // namespace gyrator

#include "gyrator/regression/check_report.hpp"

#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

std::vector<CheckRow> make_rows() {
  CheckRow good{"a/study.json",     "A & B", "one", "K", "1", "1", "± 1 %",
                RowOutcome::passed, "",      0.5};
  CheckRow bad = good;
  bad.figure = "K<\"quoted\">";
  bad.outcome = RowOutcome::failed;
  bad.explanation = "K of one: 100 % off,\nso it is";
  bad.seconds = 0;
  CheckRow note = good;
  note.outcome = RowOutcome::note;
  note.explanation = "stale";
  note.seconds = 0;
  return {good, bad, note};
}

TEST(CheckReport, TextsOfJunitAreEscaped) {
  EXPECT_EQ(escape_xml("a<b> & \"c\" 'd'"), "a&lt;b&gt; &amp; &quot;c&quot; &apos;d&apos;");
  EXPECT_EQ(escape_xml("a\nb\tc"), "a&#10;b&#9;c");
  EXPECT_EQ(escape_xml(std::string("a\x01") + "b"), "a?b");
  EXPECT_EQ(escape_xml("a\xff\xfe"), "a??");
  EXPECT_EQ(escape_xml("±"), "±");
}

TEST(CheckReport, JunitHasASuiteForEachStudyAndACaseForEachFigure) {
  const std::string xml = write_junit(make_rows());
  EXPECT_NE(xml.find("<testsuite name=\"A &amp; B\" tests=\"2\" failures=\"1\""), std::string::npos)
      << xml;
  EXPECT_NE(xml.find("<testcase classname=\"A &amp; B.one\" name=\"K\" file=\"a/study.json\" "
                     "time=\"0.500\"/>"),
            std::string::npos)
      << xml;
  EXPECT_NE(xml.find("name=\"K&lt;&quot;quoted&quot;&gt;\""), std::string::npos) << xml;
  EXPECT_NE(xml.find("<failure message=\"K of one: 100 % off,&#10;so it is\">"), std::string::npos)
      << xml;
}

TEST(CheckReport, AnnotationsAreEscapedAsGitHubAsks) {
  EXPECT_EQ(escape_github_message("50 %\r\na: b, c"), "50 %25%0D%0Aa: b, c");
  EXPECT_EQ(escape_github_property("a:b,c%\n"), "a%3Ab%2Cc%25%0A");
  EXPECT_EQ(write_github_annotations(make_rows()),
            "::error file=a/study.json,title=A & B%3A one::K of one: 100 %25 off,%0Aso it is\n"
            "::warning file=a/study.json,title=A & B%3A one::stale\n");
}

TEST(CheckReport, FailuresComeFirstInWords) {
  const std::string text = describe_check(make_rows(), true);
  EXPECT_TRUE(text.starts_with("FAIL: a/study.json: K of one: 100 % off")) << text;
  EXPECT_NE(text.find("a/study.json: 1 of 2 figures not as expected, 1 note, 0.5 s"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("one  K "), std::string::npos) << text;
}

TEST(CheckReport, BrieflyEachStudyIsALineAndOnlyWhatFailedIsTold) {
  const std::vector<CheckRow> rows = make_rows();
  CheckRow other = rows[0];
  other.study_file = "b/study.json";
  EXPECT_EQ(describe_check({other}, false), "b/study.json: 1 figure as expected, 0.5 s\n");
  EXPECT_EQ(describe_check({rows[0], rows[1], other}, false),
            "FAIL: a/study.json: K of one: 100 % off,\nso it is\n\n"
            "a/study.json: 1 of 2 figures not as expected, 0.5 s\n"
            "b/study.json: 1 figure as expected, 0.5 s\n"
            "2 studies: 1 of 3 figures not as expected, 1.0 s\n");
}

TEST(CheckReport, TheResultCountsFailuresOnly) {
  const auto result = make_check_result(make_rows());
  EXPECT_EQ(result["passed"], false);
  EXPECT_EQ(result["failed"], 1);
  EXPECT_EQ(result["figures"], 2);
  EXPECT_EQ(result["rows"].size(), 3U);
}

}  // namespace
}  // namespace gyrator

#include "gyrator/documents/output_file.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/progress.hpp"

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

namespace fs = std::filesystem;

TEST(OutputFile, AppearsOnlyWithCommitAndThenWhole) {
  const ScratchFolder folder;
  OutputFile file(folder / "result.txt");
  file.stream() << "all of it";
  EXPECT_FALSE(fs::exists(folder / "result.txt"));
  file.commit();
  EXPECT_EQ(read_text(folder / "result.txt"), "all of it");
  EXPECT_EQ(folder.count(), 1U);
}

TEST(OutputFile, LeavesTheOldFileAndNothingElseWhenAnExceptionPasses) {
  const ScratchFolder folder;
  write_text_file(folder / "result.txt", "old");
  try {
    OutputFile file(folder / "result.txt");
    file.stream() << "half of the new";
    throw std::runtime_error("stop");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(read_text(folder / "result.txt"), "old");
  EXPECT_EQ(folder.count(), 1U);
}

TEST(OutputFile, ReplacesWhatWasThereAndKeepsItsPermissions) {
  const ScratchFolder folder;
  write_text_file(folder / "result.txt", "a longer old content");
  fs::permissions(folder / "result.txt", fs::perms::owner_read | fs::perms::owner_write);
  write_text_file(folder / "result.txt", "new");
  EXPECT_EQ(read_text(folder / "result.txt"), "new");
  EXPECT_EQ(fs::status(folder / "result.txt").permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
}

TEST(OutputFile, WritesThroughASymbolicLink) {
  const ScratchFolder folder;
  write_text_file(folder / "real.txt", "old");
  fs::create_symlink("real.txt", folder / "link.txt");
  write_text_file(folder / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
  EXPECT_EQ(read_text(folder / "real.txt"), "new");
}

TEST(OutputFile, NamesTheFileAndTheReasonWhereTheFolderIsMissing) {
  const ScratchFolder folder;
  const std::string path = folder / "no_such_folder" / "result.txt";
  try {
    const OutputFile file(path);
    FAIL() << "a missing folder must be refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.place(), path);
    EXPECT_NE(error.message().find("No such file or directory"), std::string::npos) << error.what();
  }
}

TEST(OutputFile, RefusesAFolderAsTargetAndAFileAsFolder) {
  const ScratchFolder folder;
  EXPECT_THROW(OutputFile(folder.path().string()), Error);
  write_text_file(folder / "file", "");
  EXPECT_THROW(OutputFile(folder / "file" / "result.txt"), Error);
  EXPECT_THROW(OutputFile(""), Error);
}

TEST(CheckWritable, TellsWhatOutputFileWouldAndLeavesNothing) {
  const ScratchFolder folder;
  check_writable(folder / "result.txt");
  check_writable("/dev/null");
  EXPECT_EQ(folder.count(), 0U);
  EXPECT_THROW(check_writable(folder / "no_such_folder" / "result.txt"), Error);
  EXPECT_THROW(check_writable(folder.path().string()), Error);
  write_text_file(folder / "kept.txt", "kept");
  check_writable(folder / "kept.txt");
  EXPECT_EQ(read_text(folder / "kept.txt"), "kept");
}

TEST(OutputFile, WritesADeviceDirectlyAndLeavesItADevice) {
  write_text_file("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(OutputFile, TellsThatTheDiskIsFull) {
  OutputFile file("/dev/full");
  file.stream() << "does not fit";
  EXPECT_THROW(file.commit(), Error);
}

// In a process of its own: the flag and the handler stay set.
TEST(OutputFile, LeavesNothingBehindOnTheFirstInterrupt) {
  const ScratchFolder folder;
  const auto interrupted_run = [&] {
    install_interrupt_handler();
    try {
      OutputFile file(folder / "result.txt");
      file.stream() << "half";
      std::raise(SIGINT);
      throw_if_interrupted("test");
      file.commit();
    } catch (const Error& error) {
      std::_Exit(static_cast<int>(error.code()));
    }
    std::_Exit(0);
  };
  EXPECT_EXIT(interrupted_run(), testing::ExitedWithCode(130), "");
  EXPECT_EQ(folder.count(), 0U);
}

TEST(Interrupt, TheSecondOneEndsTheProcessAsUsual) {
  const auto run = [] {
    install_interrupt_handler();
    std::raise(SIGINT);
    std::raise(SIGINT);
    std::_Exit(0);
  };
  EXPECT_EXIT(run(), testing::KilledBySignal(SIGINT), "");
}

TEST(Interrupt, NothingIsThrownWithoutOne) {
  EXPECT_FALSE(interrupt_requested());
  EXPECT_NO_THROW(throw_if_interrupted("test"));
}

TEST(ProgressLine, ShowsShareRateAndTimeLeft) {
  const auto line = progress_line("map", 25, 100, 5.0, 80);
  EXPECT_NE(line.find(" 25 %"), std::string::npos) << line;
  EXPECT_NE(line.find("5/s"), std::string::npos) << line;
  EXPECT_NE(line.find("0:15 left"), std::string::npos) << line;
  EXPECT_NE(line.find("[#######  "), std::string::npos) << line;
}

TEST(ProgressLine, FitsTheTerminalAndKnowsNoEndWithoutATotal) {
  EXPECT_LE(progress_line("a long title of some work", 25, 100, 5.0, 30).size(), 30U);
  const auto line = progress_line("samples", 40, 0, 2.0, 80);
  EXPECT_EQ(line.find('%'), std::string::npos);
  EXPECT_NE(line.find("20/s"), std::string::npos) << line;
}

}  // namespace
}  // namespace gyrator

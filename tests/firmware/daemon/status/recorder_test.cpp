// What is recorded replays to the same bits; what goes wrong on the disk disturbs nothing else.

#include "firmware/daemon/status/recorder.hpp"

#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "firmware/bench/device_replay.hpp"
#include "firmware/daemon/boards/replaying.hpp"
#include "firmware/daemon/boards/simulation.hpp"
#include "firmware/daemon/loop/loop.hpp"
#include "firmware/text/settings_file.hpp"
#include "model/files/error.hpp"
#include "tests/hal/recording/mcap/files.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::recorder_test {
namespace {

constexpr std::int64_t ms = 1'000'000;

Settings<double> test_settings() {
  return bench::standard_settings();
}

/// A run of a device that is recorded.
template <class B>
class Recorded {
 public:
  template <class MakeBoard>
  Recorded(const std::string& path, const Settings<double>& settings, MakeBoard make_board,
           bool from_zero, std::size_t room = 4096)
      : desk(settings, links),
        board(make_board(desk)),
        demonstration(settings),
        ring(room),
        recorder(path, settings, ring, desk),
        device_(desk.first()),
        loop_(*board, daemon::NoPace{}, device_, command_source(), links, figures_,
              {ms, from_zero}) {
    links.record = &ring;
  }
  bool cycle() { return loop_.cycle(); }

  daemon::LoopLinks links;
  daemon::ParameterDesk desk;
  std::unique_ptr<B> board;
  daemon::Demonstration demonstration;
  daemon::Ring<daemon::CycleRecord> ring;
  daemon::Recorder recorder;

 private:
  daemon::CommandSource& command_source() {
    if constexpr (std::is_same_v<B, daemon::Replaying>) {
      return *board;
    } else {
      return demonstration;
    }
  }

  daemon::LoopFigures figures_;
  daemon::PreparedDevice device_;
  daemon::Loop<B, daemon::NoPace> loop_;
};

auto simulated() {
  return [](daemon::ParameterDesk& desk) {
    return std::make_unique<daemon::Simulation>(bench::standard_closed_loop(desk.settings()));
  };
}

/// 4 s with changes of parameters in between.
void record(const std::string& path) {
  Recorded<daemon::Simulation> run(path, test_settings(), simulated(), true);
  for (int i = 0; i < 4000; ++i) {
    if (i == 600 || i == 2200) {
      Settings<double> settings = run.desk.settings();
      settings.limits.current_A = i == 600 ? 0.15 : 0.2;
      settings.limits.temperature_K -= 5;
      settings.strain.proportional *= 1.5;
      ASSERT_TRUE(run.desk.change(stored_settings<double>(settings)));
    }
    ASSERT_TRUE(run.cycle());
    if (i % 50 == 0) {
      run.recorder.pump();
    }
  }
  run.recorder.finish();
  EXPECT_EQ(run.recorder.rows(), 4000U);
  EXPECT_EQ(run.recorder.problem(), "");
}

bench::DeviceReplayResult replayed(const std::string& path) {
  bench::DeviceReplayOptions options;
  options.trace = path;
  options.settings = text::load_settings_file(path + ".toml");
  return bench::replay_device(options);
}

TEST(Recorder, ReplaysToTheSameBitsWithItsParameterChanges) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.csv";
  record(path);
  const bench::DeviceReplayResult result = replayed(path);
  EXPECT_EQ(result.rows, 4000U);
  EXPECT_EQ(result.differing_rows, 0U);
  EXPECT_TRUE(bench::agrees(result));

  // The daemon itself on its own recording writes the same file.
  const std::string again = folder / "again.csv";
  {
    Recorded<daemon::Replaying> run(
        again, text::load_settings_file(path + ".toml"),
        [&](daemon::ParameterDesk& desk) {
          return std::make_unique<daemon::Replaying>(path, desk.settings(), desk);
        },
        false);
    while (run.cycle()) {
      run.recorder.pump();
      run.desk.tidy();
    }
    run.recorder.finish();
  }
  EXPECT_EQ(file_text(again), file_text(path));

  // Without the changes it is another run: the comparison has something to find.
  std::string text = file_text(path);
  const std::size_t change = text.find("limits.current_A=");
  ASSERT_NE(change, std::string::npos);
  text.erase(change, text.find('\n', change) - change);
  std::ofstream(path, std::ios::trunc) << text;
  EXPECT_GT(replayed(path).differing_rows, 100U);
}

/// Files of this process cannot grow beyond this as long as it lives.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(Recorder, AsMcapItIsTheSameTrace) {
  const TemporaryFolder folder;
  record(folder / "run.csv");
  record(folder / "run.mcap");
  EXPECT_EQ(file_text(folder / "run.mcap.toml"), file_text(folder / "run.csv.toml"));
  const Read read = read_mcap(file_text(folder / "run.mcap"));
  EXPECT_EQ(read.problem, "");
  EXPECT_EQ(read.cut_off, "");
  EXPECT_TRUE(read.csv == file_text(folder / "run.csv"));
  const bench::DeviceReplayResult result = replayed(folder / "run.mcap");
  EXPECT_EQ(result.rows, 4000U);
  EXPECT_EQ(result.differing_rows, 0U);
}

TEST(Recorder, AnMcapFileWithoutItsEndHasTheRowsThatAreWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.mcap";
  std::uint64_t written = 0;
  {
    Recorded<daemon::Simulation> run(path, test_settings(), simulated(), true);
    // Chunks are closed once a second of the clock, or when they are full.
    for (int i = 0; i < 20'000; ++i) {
      ASSERT_TRUE(run.cycle());
      if (i % 500 == 0) {
        run.recorder.pump();
      }
    }
    written = run.recorder.rows();
    EXPECT_EQ(run.recorder.problem(), "");
  }
  EXPECT_GT(written, 0U);
  EXPECT_LT(written, 20'000U);
  const bench::DeviceReplayResult result = replayed(path);
  EXPECT_EQ(result.rows, written);
  EXPECT_EQ(result.skipped, 1U);
  EXPECT_EQ(result.differing_rows, 0U);
}

TEST(Recorder, AFullDiskLeavesWholeChunks) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.mcap";
  std::uint64_t rows = 0;
  {
    Recorded<daemon::Simulation> run(path, test_settings(), simulated(), true);
    const FullDisk full(200'000);
    for (int i = 0; i < 20'000; ++i) {
      ASSERT_TRUE(run.cycle());
      if (i % 500 == 0) {
        run.recorder.pump();
      }
    }
    run.recorder.finish();
    EXPECT_NE(run.recorder.problem(), "");
    rows = run.recorder.rows();
  }
  EXPECT_GT(rows, 100U);
  EXPECT_LT(rows, 20'000U);
  const bench::DeviceReplayResult result = replayed(path);
  EXPECT_EQ(result.rows, rows);
  EXPECT_EQ(result.differing_rows, 0U);
}

TEST(Recorder, NeverOverwrites) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.csv";
  std::ofstream(path) << "precious\n";
  EXPECT_THROW(Recorded<daemon::Simulation>(path, test_settings(), simulated(), true),
               files::UserError);
  EXPECT_EQ(file_text(path), "precious\n");
  EXPECT_THROW(
      Recorded<daemon::Simulation>(folder / "no/run.csv", test_settings(), simulated(), true),
      files::UserError);
}

TEST(Recorder, AFullDiskLeavesWholeRowsAndARunningLoop) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.csv";
  std::uint64_t rows = 0;
  {
    Recorded<daemon::Simulation> run(path, test_settings(), simulated(), true);
    const FullDisk full(200'000);
    for (int i = 0; i < 3000; ++i) {
      ASSERT_TRUE(run.cycle());
      if (i % 20 == 0) {
        run.recorder.pump();
      }
    }
    run.recorder.finish();
    EXPECT_NE(run.recorder.problem(), "");
    rows = run.recorder.rows();
  }
  EXPECT_GT(rows, 100U);
  EXPECT_LT(rows, 3000U);
  EXPECT_TRUE(file_text(path).ends_with('\n'));
  const bench::DeviceReplayResult result = replayed(path);
  EXPECT_EQ(result.rows, rows);
  EXPECT_EQ(result.differing_rows, 0U);
}

TEST(Recorder, ASlowDiskEndsTheRecordingAtTheGap) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.csv";
  daemon::Ring<daemon::CycleRecord> ring(64);
  daemon::LoopLinks links;
  daemon::ParameterDesk desk(test_settings(), links);
  daemon::Recorder recorder(path, test_settings(), ring, desk);
  daemon::CycleRecord cycle{};
  const auto cycles = [&](std::uint64_t from, std::uint64_t to) {
    for (cycle.number = from; cycle.number <= to; ++cycle.number) {
      cycle.cycle.time_s = 1e-3 * static_cast<double>(cycle.number);
      ring.push(cycle);
    }
  };
  cycles(1, 40);
  recorder.pump();
  cycles(41, 200);  // nobody takes them: 64 stay
  recorder.pump();
  cycles(201, 210);
  recorder.finish();
  EXPECT_EQ(recorder.rows(), 104U);
  EXPECT_NE(recorder.problem().find("too slow"), std::string::npos) << recorder.problem();
}

TEST(Recorder, APowerCutCostsTheRowsThatAreNotWritten) {
  // What is in the file at any time is a trace, even if nobody finishes it.
  const TemporaryFolder folder;
  const std::string path = folder / "run.csv";
  Recorded<daemon::Simulation> run(path, test_settings(), simulated(), true);
  for (int i = 0; i < 700; ++i) {
    ASSERT_TRUE(run.cycle());
  }
  run.recorder.pump();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(run.cycle());
  }
  const bench::DeviceReplayResult result = replayed(path);
  EXPECT_EQ(result.rows, 700U);
  EXPECT_EQ(result.differing_rows, 0U);
}

}  // namespace
}  // namespace smaservo::test::recorder_test

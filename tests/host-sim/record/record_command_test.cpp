// host-sim record as its user meets it: folders that are made, added to and checked.

#include <csignal>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <regex>
#include <sys/file.h>
#include <sys/stat.h>

#include "hal/linux/system/descriptor.hpp"
#include "hal/replay/trace.hpp"
#include "host-sim/end_by_signal.hpp"
#include "host-sim/identify/runs/run.hpp"
#include "host-sim/record/folder.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/host-sim/record/data_set.hpp"

namespace smaservo::test::record_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;
using Texts = Program::Texts;
namespace fs = std::filesystem;

struct RecordCommand : ::testing::Test {
  RecordCommand() {
    write("card.toml", filled_card());
    write("a.csv", joule_file());
  }
  void write(const std::string& name, const std::string& text) const {
    program.folder().write(name, text);
  }
  std::string path(const std::string& name) const { return program.folder() / name; }
  Finished record(const Texts& runs, const std::string& card = "card.toml") {
    Texts arguments{"record", "--card", card, "--out", "set"};
    arguments.insert(arguments.end(), runs.begin(), runs.end());
    return program.run(arguments);
  }
  void made(const Texts& runs) {
    const Finished f = record(runs);
    ASSERT_EQ(f.status, 0) << f.err;
  }
  Finished check(const std::string& folder = "set") {
    return program.run({"record", "--check", folder});
  }
  /// Nothing has changed in the folder that the command works in.
  void refuses(const Texts& runs, const std::string& reason, int status = 1) {
    const auto before = content_of(program.folder().path());
    const Finished f = record(runs);
    EXPECT_EQ(f.status, status) << f.err;
    EXPECT_THAT(f.err, HasSubstr(reason));
    EXPECT_EQ(f.out, "");
    EXPECT_EQ(content_of(program.folder().path()), before);
  }
  void finds(const std::string& reason) {
    const auto before = content_of(program.folder().path());
    const Finished f = check();
    EXPECT_EQ(f.status, 1) << f.out;
    EXPECT_THAT(f.err, HasSubstr(reason));
    EXPECT_EQ(f.out, "");
    EXPECT_EQ(content_of(program.folder().path()), before);
  }

  /// With host-sim as $0.
  void shell(const std::string& script) {
    program.launcher = {"/bin/bash", "-c", script, test::host_sim_program()};
    const Finished f = program.run({});
    EXPECT_EQ(f.status, 0) << f.err;
    program.launcher.clear();
  }

  Program program;
};

TEST_F(RecordCommand, MakesAFolderThatCommandsAndStandardToolsRead) {
  write("b.csv", joule_file(0.9));
  const Finished f = record({"a.csv", "b.csv"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_EQ(f.err, "");
  EXPECT_THAT(f.out, HasSubstr("set: made, 2 runs in all; wire.toml is smartflex-76um"));
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("card.toml", "a.csv", "b.csv", "set"));
  std::vector<std::string> names;
  for (const auto& [name, text] : content_of(path("set"))) {
    names.push_back(name);
  }
  EXPECT_THAT(names, ElementsAre("README.md", "SHA256SUMS", "card.toml", "runs", "runs/a.csv",
                                 "runs/b.csv", "wire.toml"));
  EXPECT_EQ(file_text(path("set/card.toml")), filled_card());
  EXPECT_EQ(file_text(path("set/runs/a.csv")), joule_file());
  EXPECT_EQ(check().status, 0);
  program.launcher = {"/bin/sh", "-c", "cd set && sha256sum -c --strict SHA256SUMS"};
  EXPECT_EQ(program.run({}).status, 0);
  program.launcher.clear();
  const Finished replayed =
      program.run({"replay", "--wire", "set/wire.toml", "set/runs/a.csv", "--json"});
  EXPECT_EQ(replayed.status == 0 || replayed.status == 3, true) << replayed.err;
}

// The README's commands do what it says, in the folder.
TEST_F(RecordCommand, TheCommandsOfTheReadmeWork) {
  made({"a.csv"});
  const std::string readme = file_text(path("set/README.md"));
  for (const char* const command : {"record --check .", "inspect --wire wire.toml runs/a.csv",
                                    "replay --wire wire.toml --report report.html runs/a.csv",
                                    "identify --from wire.toml --out fitted.toml runs/a.csv"}) {
    EXPECT_THAT(readme, HasSubstr("\n    host-sim " + std::string(command) + "\n"));
  }
  program.launcher = {"/bin/sh", "-c",
                      "cd set && \"$0\" record --check . && \"$0\" inspect --wire wire.toml "
                      "runs/a.csv && sha256sum -c SHA256SUMS",
                      test::host_sim_program()};
  const Finished f = program.run({});
  EXPECT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(readme,
              AllOf(HasSubstr("# a wire that is known by heart\n"),
                    HasSubstr("https://spdx.org/licenses/CC0-1.0.html"),
                    HasSubstr("| length | 100 mm |"), HasSubstr("| [a](runs/a.csv) | 200 |")));
}

/// Each command of the folder's README, as a user would paste it.
TEST_F(RecordCommand, TheCommandsOfALargerReadmeWork) {
  Texts runs;
  for (int i = 0; i < 13; ++i) {
    runs.push_back(fmt::format("r{}.csv", i));
    write(runs.back(), joule_file());
  }
  made(runs);
  const std::string readme = file_text(path("set/README.md"));
  EXPECT_THAT(readme, AllOf(HasSubstr("inspect --wire wire.toml runs/*.csv\n"),
                            HasSubstr("--out fitted.toml runs/*.csv\n"), Not(HasSubstr("..."))));
  const test::Recording r;
  write("light.csv",
        csv({{"time_s", r.time_s}, {"current_A", r.current_A}, {"voltage_V", r.voltage_V}}));
  made({"light.csv", "--stress-MPa", "9000", "--allow", "stress"});
  shell(
      "cd set && grep -E '^    host-sim (record|inspect)' README.md >../commands && "
      "host-sim() { \"$0\" \"$@\"; } && set -e && . ../commands");
  EXPECT_THAT(file_text(path("commands")),
              HasSubstr("inspect --wire wire.toml runs/r0.csv runs/r1"));
}

/// What commands read of a run.
std::vector<std::vector<double>> numbers(const std::string& path, hal::TraceOptions options = {}) {
  options.resistance_and_power = true;
  hal::TraceReader trace(path, options);
  hal::TraceRow row{};
  std::vector<std::vector<double>> all;
  while (trace.next(row)) {
    all.emplace_back(row.values.begin(), row.values.end());
    for (double& value : all.back()) {
      value = std::isnan(value) ? -1 : value;  // equal to itself
    }
  }
  return all;
}

/// The table of a logger: semicolons, decimal commas, minutes, grams, its own names.
std::string foreign_file() {
  const test::Recording r;
  std::string text = "Messung 7;;;;\nZeit [min];I (mA);U/V;Kraft_g;Weg [mm];note\n";
  for (std::size_t i = 0; i < r.time_s.size(); ++i) {
    std::string row =
        fmt::format("{};{};{};{:.3f};{:.5f};x{}", r.time_s[i] / 60, 1e3 * r.current_A[i],
                    r.voltage_V[i], 69.34, 100 * (0.041 - r.strain[i]), i);
    std::ranges::replace(row, '.', ',');
    text += row + '\n';
  }
  return text;
}

// A round trip: the copy has the numbers of the source, to the last bit, for each command.
TEST_F(RecordCommand, NumbersStayTheSameToTheLastBit) {
  write("logger.txt", foreign_file());
  made({"logger.txt", "--column", "displacement=Weg [mm]:mm"});
  hal::TraceOptions options;
  options.renames = {"displacement=Weg [mm]:mm"};
  const auto before = numbers(path("logger.txt"), options);
  EXPECT_EQ(before.size(), 200U);
  EXPECT_EQ(numbers(path("set/runs/logger.csv")), before);
  const std::string copy = file_text(path("set/runs/logger.csv"));
  EXPECT_THAT(copy, HasSubstr("current_mA,voltage_V,load_gf,displacement_mm,note\n"));
  EXPECT_THAT(copy, HasSubstr(",69.340,")) << "digits that were recorded, zeros too";
  identify::RunOptions original = of_recorded_wire();
  original.trace = options;
  const identify::Run a = identify::read_run(path("logger.txt"), original);
  const identify::Run b = identify::read_run(path("set/runs/logger.csv"), of_recorded_wire());
  EXPECT_EQ(a.time_s, b.time_s);
  EXPECT_EQ(a.current_A, b.current_A);
  EXPECT_EQ(a.voltage_V, b.voltage_V);
  EXPECT_EQ(a.stress_Pa, b.stress_Pa);
  EXPECT_EQ(a.strain, b.strain);
}

TEST_F(RecordCommand, AConstantLoadAndAPeriodBecomeColumns) {
  const test::Recording r;
  write("bare.csv", csv({{"current_A", r.current_A}, {"voltage_V", r.voltage_V}}));
  refuses({"bare.csv"}, "bare.csv: lacks a time (time_s, or --period-s), a load (load_N");
  refuses({"bare.csv", "--period-s", "0.1"}, "lacks a load");
  made({"bare.csv", "--period-s", "0.1", "--load-N", "0.68"});
  const std::string copy = file_text(path("set/runs/bare.csv"));
  EXPECT_TRUE(copy.starts_with("time_s,current_A,voltage_V,load_N\n0,")) << copy.substr(0, 60);
  EXPECT_THAT(copy, HasSubstr(",0.68\n"));
  hal::TraceOptions options;
  options.period_s = 0.1;
  const auto before = numbers(path("bare.csv"), options),
             after = numbers(path("set/runs/bare.csv"));
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i][0], before[i][0]);
  }
  refuses({"a.csv", "--load-N", "1"}, "a.csv: has a column of the load, so --load-N");
}

TEST_F(RecordCommand, TheCardsWeightIsTheLoadOfRunsWithoutOne) {
  const test::Recording r;
  write("card.toml", filled_card({{"force_N", "force_mN = 680.50"}}));
  write("bare.csv",
        csv({{"time_s", r.time_s}, {"current_A", r.current_A}, {"voltage_V", r.voltage_V}}));
  made({"bare.csv"});
  EXPECT_THAT(file_text(path("set/runs/bare.csv")), HasSubstr("voltage_V,load_mN\n"));
  EXPECT_DOUBLE_EQ(numbers(path("set/runs/bare.csv")).front()[3], 0.6805);
}

TEST_F(RecordCommand, AddsRunsToTheSameCardAndOverwritesNothing) {
  made({"a.csv"});
  const auto first = content_of(path("set"));
  write("b.csv", joule_file(0.5));
  made({"b.csv", "--run", "later"});
  EXPECT_EQ(check().status, 0);
  EXPECT_EQ(file_text(path("set/runs/a.csv")), joule_file());
  EXPECT_THAT(file_text(path("set/README.md")), HasSubstr("[later](runs/later.csv)"));
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("card.toml", "a.csv", "b.csv", "set"));
  refuses({"a.csv"}, "set/runs/a.csv: is there already, and nothing is overwritten");
  refuses({"b.csv", "--run", "LATER"}, "set/runs/later.csv: is there already");
  refuses({"b.csv", "a.csv"}, "set/runs/a.csv: is there already");
  write("card.toml", filled_card({{"by", "by = \"B. Tester\""}}));
  refuses({"b.csv"}, "card.toml:3: differs from the card of set");
  EXPECT_EQ(record({"b.csv"}, "set/card.toml").status, 0);
  EXPECT_EQ(check().out, "set: 3 runs, 600 rows: nothing is wrong\n");
}

TEST_F(RecordCommand, TakesAnEmptyFolderAndNoOther) {
  mkdir(path("set").c_str(), 0777);
  made({"a.csv"});
  mkdir(path("other").c_str(), 0777);
  write("other/thesis.txt", "years of work");
  fs::create_symlink("nothing", path("dangling"));
  const Texts into_other{"--card", "card.toml", "a.csv"};
  for (const auto& [out, said] : std::vector<std::pair<std::string, std::string>>{
           {"other", "--out other: holds other files and is no folder of runs"},
           {"a.csv", "--out a.csv: is a file and no folder"},
           {"no/where", "--out no/where: there is no folder"},
           {"dangling", "--out dangling: is a link to nothing"},
           {std::string(300, 'x'), "File name too long"},
           {".", "--out .: holds other files"}}) {
    const Finished f = program.run({"record", "--card", "card.toml", "--out", out, "a.csv"});
    EXPECT_EQ(f.status, 1);
    EXPECT_THAT(f.err, HasSubstr(said));
  }
  EXPECT_EQ(file_text(path("other/thesis.txt")), "years of work");
  EXPECT_EQ(program.run({"record", "--card", "card.toml", "--out", "with stroke/", "a.csv"}).status,
            0);
  EXPECT_EQ(check("with stroke").status, 0);
}

TEST_F(RecordCommand, RefusesBadRunsAndLeavesNothing) {
  const std::string header = "time_s,current_A,voltage_V,load_N\n";
  const std::pair<std::string, std::string> wrong[] = {
      {"", "is empty"},
      {header, "has a header and no row"},
      {header + "0,0.1,2,0.6\n1,nan,2,0.6\n",
       "line 3, column 2 (current_A): 'nan' is not a finite"},
      {header + "0,0.1,2,0.6\n1,0.1,,0.6\n", "line 3, column 3 (voltage_V)"},
      {header + "0,0.1,2,0.6\n0,0.1,2,0.6\n", "line 3"},
      {header + "0,0.1,2\n", "line 2"},
      {"time_s,current_A,load_N\n0,0.1,0.6\n",
       "lacks a voltage (voltage_V) or a resistance (resistance_ohm); it has the columns: time_s, "
       "current_A, load_N"},
      {"time_h,current_A,voltage_V,load_N\n0,0.1,2,0.6\n", "time_h"},
      {std::string(5000, '\0'), "x.csv"},
  };
  for (const auto& [text, said] : wrong) {
    write("x.csv", text);
    refuses({"x.csv"}, said);
    refuses({"a.csv", "x.csv"}, said);
  }
  refuses({"missing.csv"}, "missing.csv: No such file");
  mkdir(path("folder").c_str(), 0777);
  refuses({"folder"}, "folder: is no file");
}

// Milliamperes that are called amperes: the project's checks, with the source's line and column.
TEST_F(RecordCommand, RefusesWhatTheChecksFindUnlessAllowed) {
  test::Recording r;
  r.current_A = times(1e3, r.current_A);
  write("x.csv", csv({{"time_s", r.time_s},
                      {"current_A", r.current_A},
                      {"voltage_V", r.voltage_V},
                      {"load_N", std::vector<double>(200, 0.68)}}));
  refuses({"x.csv"}, "column 2 'current_A' is probably in mA and not in A: --column current=2:mA");
  refuses({"x.csv", "--allow", "nonsense"}, "--allow nonsense: there is no such check");
  write("light.csv", csv({{"time_s", r.time_s},
                          {"current_A", times(1e-3, r.current_A)},
                          {"voltage_V", r.voltage_V}}));
  refuses({"light.csv", "--stress-MPa", "9000"}, "to go on all the same: --allow stress");
  const Finished f = record({"light.csv", "--stress-MPa", "9000", "--allow", "stress"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.err, HasSubstr("light.csv: "));
  EXPECT_THAT(file_text(path("set/README.md")),
              AllOf(HasSubstr("record --check . --allow stress"), HasSubstr("mistake (`stress`)")));
  finds("to take it for a note: --allow stress");
  EXPECT_EQ(program.run({"record", "--check", "set", "--allow", "stress"}).status, 0);
}

TEST_F(RecordCommand, TheDisplacementCountsContraction) {
  const test::Recording r;
  write("up.csv", csv({{"time_s", r.time_s},
                       {"current_A", r.current_A},
                       {"voltage_V", r.voltage_V},
                       {"load_N", std::vector<double>(200, 0.68)},
                       {"x", times(100, r.strain)}}));
  refuses({"up.csv", "--column", "displacement_mm=x"}, "--column displacement_mm=5*-1");
  const Texts turned{"up.csv", "--column", "displacement_mm=x*-1"};
  made(turned);
  EXPECT_DOUBLE_EQ(numbers(path("set/runs/up.csv")).front()[8], -1e-1 * r.strain.front());
  EXPECT_EQ(check().status, 0);
  // A run of a folder can be recorded again, with the folder's own card.
  const Finished again =
      program.run({"record", "--card", "set/card.toml", "--out", "again", "set/runs/up.csv"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(file_text(path("again/runs/up.csv")), file_text(path("set/runs/up.csv")));
  fs::remove_all(path("set"));
  write("card.toml",
        filled_card({{"sensor", "sensor = \"none\""}, {"resolution_um", ""}, {"zero", ""}}));
  refuses(turned, "the card says that there is no such sensor");
  made({"up.csv"});
  EXPECT_THAT(file_text(path("set/README.md")), HasSubstr("No run has a displacement"));
}

TEST_F(RecordCommand, NamesThatSomeSystemsCannotHoldAreRefused) {
  write("run 7.csv", joule_file());
  refuses({"run 7.csv"}, "run 7.csv: the name 'run 7' of a run: must be made of");
  refuses({"run 7.csv"}, "give another one: --run run-7");
  for (const char* const name : {"..", "../x", "-x", ".x", "a/b", "a\nb", "\x1B[2J", "ü"}) {
    const Finished f = record({"a.csv", std::string("--run=") + name});
    EXPECT_EQ(f.status, 1) << name;
    EXPECT_EQ(f.err.find('\x1B'), std::string::npos);
    EXPECT_FALSE(fs::exists(path("set")));
  }
  mkdir(path("deep").c_str(), 0777);
  write("deep/a.csv", joule_file());
  refuses({"a.csv", "deep/a.csv"}, "a.csv and deep/a.csv: both would be the run a");
  refuses({"a.csv", "deep/a.csv", "--run", "x"}, "--run: names one run, and several are given");
}

TEST_F(RecordCommand, TextsOfACardStayTexts) {
  write("card.toml", filled_card({{"title", R"(title = "a | b <img src=x> [l](u) `c`")"},
                                  {"remarks", R"(remarks = "one\ntwo\u001B[2J")"}}));
  made({"a.csv"});
  const std::string readme = file_text(path("set/README.md"));
  EXPECT_THAT(readme, HasSubstr(R"(# a \| b \<img src=x\> \[l\](u) \`c\`)"));
  EXPECT_THAT(readme, HasSubstr("| one two"));
  EXPECT_EQ(readme.find('\x1B'), std::string::npos);
}

// A limit on the size of files is what a test has of a full disk.
TEST_F(RecordCommand, AFullDiskLeavesNothing) {
  for (const char* const blocks : {"1", "2", "8", "16", "64"}) {
    fs::remove_all(path("set"));
    program.launcher = {"/bin/sh", "-c",
                        std::string("trap '' XFSZ; ulimit -f ") + blocks + "; exec \"$0\" \"$@\"",
                        test::host_sim_program()};
    const Finished f = record({"a.csv"});
    const bool is_whole = f.status == 0;
    EXPECT_EQ(fs::exists(path("set")), is_whole) << blocks << f.err;
    EXPECT_THAT(program.folder().names().size(), is_whole ? 3U : 2U) << blocks;
    program.launcher.clear();
    if (is_whole) {
      continue;
    }
    EXPECT_THAT(f.err, HasSubstr("File too large")) << blocks;
    made({"a.csv", "--run", "first"});
    const auto before = content_of(path("set"));
    program.launcher = {"/bin/sh", "-c",
                        std::string("trap '' XFSZ; ulimit -f ") + blocks + "; exec \"$0\" \"$@\"",
                        test::host_sim_program()};
    EXPECT_EQ(record({"a.csv"}).status, 1);
    EXPECT_EQ(content_of(path("set")), before) << blocks;
    program.launcher.clear();
  }
}

TEST_F(RecordCommand, OneAtATimeAddsToAFolder) {
  made({"a.csv"});
  const hal::Descriptor held(open(path("set").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ASSERT_EQ(flock(held.number(), LOCK_EX), 0);
  refuses({"a.csv", "--run", "b"}, "--out set: another host-sim record is adding to it");
}

// Several begin at once: the folder is one of them's, whole, and the others say so.
TEST_F(RecordCommand, OneOfSeveralMakesTheFolder) {
  const std::string begin =
      "for i in 1 2 3 4; do \"$0\" record --card card.toml --out set a.csv & ";
  program.launcher = {"/bin/sh", "-c", begin + "done; wait", test::host_sim_program()};
  const Finished f = program.run({});
  program.launcher.clear();
  EXPECT_EQ(check().status, 0) << f.err;
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("card.toml", "a.csv", "set"));
  EXPECT_EQ(f.out.find("set: made"), f.out.rfind("set: made")) << f.out;
}

// Not even what looks like the folder of a killed call: it may be the user's.
TEST_F(RecordCommand, NothingThatIsThereIsRemoved) {
  const std::string mine[] = {"set.raw-data.part", "set.somehost.1.part", "set/new.mine.part",
                              "set/new.somehost.1.part"};
  const auto make_old = [&](const std::string& name) {
    mkdir(path(name).c_str(), 0777);
    write(name + "/x", "mine");
    fs::last_write_time(path(name), fs::file_time_type::clock::now() - std::chrono::hours(2));
  };
  make_old(mine[0]);
  make_old(mine[1]);
  made({"a.csv"});
  make_old(mine[2]);
  make_old(mine[3]);
  made({"a.csv", "--run", "b"});
  for (const std::string& name : mine) {
    EXPECT_EQ(file_text(path(name + "/x")), "mine") << name;
  }
  EXPECT_EQ(check().status, 0);
}

TEST_F(RecordCommand, AFolderThatHasChangedIsNotAddedTo) {
  made({"a.csv"});
  write("b.csv", joule_file());
  const std::string wire = file_text(path("set/wire.toml"));
  write("set/wire.toml", wire + "\n");
  refuses({"b.csv"}, "set/wire.toml: has changed: its SHA-256 is ");
  refuses({"b.csv"}, "nothing is added to a folder that has changed");
  write("set/wire.toml", wire);
  write("set/runs/b.csv", joule_file());
  refuses({"b.csv"}, "set/runs/b.csv: is not in SHA256SUMS; nothing is added");
}

// Else the next list and the README would not have these files.
TEST_F(RecordCommand, NothingIsAddedWhereTheListLacksFiles) {
  made({"a.csv"});
  write("b.csv", joule_file());
  const std::string sums = file_text(path("set/SHA256SUMS"));
  for (const std::string name : {"card.toml", "wire.toml", "README.md", "runs/a.csv"}) {
    const std::size_t end = sums.find(name) + name.size() + 1;
    const std::size_t begin = sums.rfind('\n', end - 2) + 1;
    write("set/SHA256SUMS", sums.substr(0, begin) + sums.substr(end));
    refuses({"b.csv"}, "set/" + name + ": is not in SHA256SUMS; nothing is added");
  }
  fs::remove(path("set/README.md"));
  write("set/SHA256SUMS", "");
  refuses({"b.csv"}, "is not in SHA256SUMS; nothing is added");
}

TEST_F(RecordCommand, LinesOfTheListStay) {
  made({"a.csv"});
  write("set/photo.png", "\x89PNG");
  shell("cd set && sha256sum photo.png >>SHA256SUMS");
  const std::string before = file_text(path("set/SHA256SUMS"));
  made({"a.csv", "--run", "b"});
  const std::string after = file_text(path("set/SHA256SUMS"));
  EXPECT_THAT(after, HasSubstr("  photo.png\n"));
  EXPECT_THAT(after, HasSubstr(before.substr(before.find("  README.md") + 12)));
  EXPECT_EQ(check().err, "");
  write("set/photo.png", "other");
  refuses({"a.csv", "--run", "c"}, "set/photo.png: has changed");
}

/// A folder that is about to get a run more.
struct FolderOfRuns : RecordCommand {
  std::unique_ptr<record::Folder> opened() {
    made({"a.csv"});
    auto folder =
        std::make_unique<record::Folder>(path("set"), record::load_card(path("card.toml")));
    folder->begin();
    folder->stage(record::readme_name, "anew\n");
    folder->stage("runs/b.csv", joule_file());
    return folder;
  }
};

// What changes between the comparison and the end keeps the sum that it had.
TEST_F(FolderOfRuns, AChangeMeanwhileGetsNoSum) {
  const auto folder = opened();
  write("set/runs/a.csv", "time_s\n");
  folder->complete({"b"});
  finds("set/runs/a.csv: has changed: its SHA-256 is ");
}

TEST_F(FolderOfRuns, ALateSignalAddsNothing) {
  const auto before = std::signal(SIGTERM, [](int) {});
  {
    const auto folder = opened();
    const auto content = content_of(path("set/runs"));
    const EndBySignal guard;
    std::raise(SIGTERM);
    ::testing::internal::CaptureStderr();
    EXPECT_THROW(folder->complete({"b"}), files::UserError);
    EXPECT_THAT(::testing::internal::GetCapturedStderr(),
                HasSubstr("set: ended by a signal; nothing is added"));
    folder->abandon();
    EXPECT_EQ(content_of(path("set/runs")), content);
  }
  std::signal(SIGTERM, before);
  EXPECT_EQ(check().status, 0);
}

// As it is after a failure between the renames of SHA256SUMS and of README.md.
TEST_F(RecordCommand, AReadmeThatDiffersIsMadeAnewAndKept) {
  made({"a.csv"});
  write("set/README.md", "mine");
  finds("set/README.md: has changed");
  made({"a.csv", "--run", "b"});
  EXPECT_EQ(file_text(path("set/README.md.old-1")), "mine");
  fs::remove(path("set/README.md"));
  finds("set/README.md: is missing");
  made({"a.csv", "--run", "c"});
  mkdir(path("set/x").c_str(), 0777);
  write("set/README.md", "mine, too");
  made({"a.csv", "--run", "d"});
  EXPECT_EQ(file_text(path("set/README.md.old-1")), "mine");
  EXPECT_EQ(file_text(path("set/README.md.old-2")), "mine, too");
  EXPECT_THAT(file_text(path("set/README.md")), HasSubstr("[d](runs/d.csv)"));
  EXPECT_EQ(check().status, 0);
}

TEST_F(RecordCommand, AFileThatWasCutOffIsRefused) {
  const std::string whole = joule_file();
  const std::string cut = whole.substr(0, whole.rfind(','));
  write("cut.csv", cut);
  refuses({"cut.csv"}, "the last line has no end, so the file was cut off there");
  refuses({"a.csv", "cut.csv"}, "cut.csv: line 201");
  write("cut.txt", foreign_file().substr(0, foreign_file().rfind(';') - 5));
  refuses({"cut.txt", "--column", "displacement=Weg [mm]:mm"}, "cut off");
  write("number.csv", whole.substr(0, whole.size() - 3));
  const Finished said = record({"number.csv"});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.err, HasSubstr("number.csv: its last line has no end; if the file was cut off"));
  made({"a.csv"});
  write("set/runs/a.csv", cut);
  shell("cd set && sha256sum card.toml wire.toml README.md runs/* >SHA256SUMS");
  finds("set/runs/a.csv: line 201");
}

TEST_F(RecordCommand, CommasInTextsThatBecomeSemicolonsAreSaid) {
  const std::string rows =
      "time_s;current_A;voltage_V;load_N;note\n0;0.1;2;0.6;\"a,b\"\n1;0.1;2;0.6;c\n";
  write("texts.csv", rows);
  const Finished f = record({"texts.csv"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(file_text(path("set/runs/texts.csv")), HasSubstr(",a;b\n"));
  EXPECT_THAT(f.err, HasSubstr("texts.csv: commas in its texts are written as semicolons\n"));
  write("plain.csv", std::string(rows).replace(rows.find("a,b"), 3, "a b"));
  EXPECT_THAT(record({"plain.csv"}).err, Not(HasSubstr("semicolons\n")));
}

TEST_F(RecordCommand, WhatContradictsTheCardIsRefused) {
  const test::Recording r;
  write("card.toml", filled_card({{"force_N", "force_mN = 680"}}));
  write("bare.csv",
        csv({{"time_s", r.time_s}, {"current_A", r.current_A}, {"voltage_V", r.voltage_V}}));
  write("heavy.csv", joule_file(1.77));
  refuses({"heavy.csv"},
          "heavy.csv: is heated under a load of 1.77 N, and by the card load.force "
          "is 0.68 N in all runs");
  refuses({"bare.csv", "--load-N", "1.77"}, "is heated under a load of 1.77 N");
  refuses({"a.csv", "--period-s", "2"}, "a.csv: has a time, so --period-s is not for it");
  write("near.csv", joule_file(0.7));
  made({"near.csv", "bare.csv"});
  write("set/card.toml", filled_card({{"force_N", "force_N = 1"}}));
  finds("set/runs/near.csv: is heated under a load of 0.7 N, and by the card load.force is 1 N");
}

TEST_F(RecordCommand, ChecksCompareTheWireWithTheCard) {
  made({"a.csv"});
  const std::string wire = file_text(path("set/wire.toml"));
  const auto changed = [&](const std::string& pattern, const std::string& by) {
    write("set/wire.toml", std::regex_replace(wire, std::regex(pattern), by,
                                              std::regex_constants::format_first_only));
    EXPECT_NE(file_text(path("set/wire.toml")), wire) << pattern;
    shell("cd set && sha256sum card.toml wire.toml README.md runs/* >SHA256SUMS");
  };
  changed("(resistivity[a-z_]* = )[0-9.]+", "$019");
  finds("set/wire.toml: wire.cold_resistance is ");
  changed("(\nspecific_heat[a-zA-Z_]* = )[0-9.]+", "$01123");
  EXPECT_THAT(check().err, HasSubstr("set/wire.toml: differs from what this version"));
  write("set/wire.toml", wire);
  write("set/card.toml", filled_card({{"cold_resistance_ohm", "cold_resistance_ohm = 24"}}));
  finds("set/wire.toml: wire.cold_resistance is 22 ohm, and card.toml has 24 ohm");
}

TEST_F(RecordCommand, ChecksNameFilesThatNoCommandReads) {
  made({"a.csv"});
  mkdir(path("set/runs/more").c_str(), 0777);
  write("set/runs/more/b.csv", joule_file());
  write("set/runs/c.csv.gz", "packed");
  finds("set/runs/more/b.csv: is no run that commands read");
  finds("set/runs/c.csv.gz: is no run that commands read");
  fs::remove_all(path("set/runs/more"));
  fs::remove(path("set/runs/c.csv.gz"));
  EXPECT_EQ(check().status, 0);
  write("set/runs/A.csv", joule_file());
  finds("set/runs/a.csv: is runs/A.csv in other letters");
}

TEST_F(RecordCommand, TheCommandLineIsJudged) {
  refuses({}, "RUN or --can", 2);
  refuses({"a.csv", "--load-N", "1", "--stress-MPa", "2"}, "--load-N", 2);
  refuses({"--can", "udp"}, "--seconds", 2);
  refuses({"--can", "udp", "--seconds", "nan"}, "--seconds", 2);
  refuses({"a.csv", "--can", "udp", "--seconds", "1"}, "--can", 2);
  refuses({"a.csv", "--seconds", "1"}, "--seconds", 2);
  refuses({"a.csv", "--check", "set"}, "--check", 2);
  refuses({"--load-N", "1", "--check", "set"}, "--check", 2);
  refuses({"a.csv", "--load-N", "-1"}, "--load-N -1: must be between 0 and 100000");
  refuses({"a.csv", "--load-N", "nan"}, "--load-N nan: must be between");
  refuses({"a.csv", "--period-s", "0"}, "--period-s 0: must be between");
  refuses({"a.csv", "--column", "current=9:mA"}, "--column current=9:mA");
  EXPECT_EQ(program.run({"record"}).status, 2);
  EXPECT_EQ(program.run({"record", "--card", "card.toml", "a.csv"}).status, 2);
  EXPECT_EQ(program.run({"record", "--new-card", "--check", "x"}).status, 2);
  EXPECT_EQ(record({"a.csv"}, "missing.toml").status, 1);
  EXPECT_EQ(record({"a.csv"}, ".").status, 1);
}

TEST_F(RecordCommand, ANewCardIsOnStandardOutput) {
  const Finished f = program.run({"record", "--new-card"});
  ASSERT_EQ(f.status, 0);
  EXPECT_EQ(f.err, "");
  EXPECT_THAT(f.out, HasSubstr("\n#!length_mm = 120\n"));
  write("card.toml", f.out);
  refuses({"a.csv"}, "card.toml: missing: data.title, data.by, data.licence, wire.length_mm");
}

TEST_F(RecordCommand, ChecksNameEveryFault) {
  made({"a.csv"});
  write("set/picture.png", "\x89PNG");
  const Finished noted = check();
  EXPECT_EQ(noted.status, 0);
  EXPECT_EQ(noted.err,
            "host-sim: set/picture.png: is not in SHA256SUMS, and no part of the data set\n");
  EXPECT_EQ(noted.out, "set: 1 run, 200 rows: nothing is wrong\n");
  write("set/runs/b.csv", joule_file());
  finds("set/runs/b.csv: is not in SHA256SUMS");
  write("set/runs/a.csv", "time_s,current_A,voltage_V,load_N\n0,0.1,2,x\n");
  finds("set/runs/a.csv: line 2, column 4 (load_N): 'x' is not a finite number");
  finds("set/runs/a.csv: has changed: its SHA-256 is ");
  write("set/runs/a.csv", foreign_file());
  finds("set/runs/a.csv: is not in this project's columns, as a run is, but separated by semi");
  write("set/card.toml", filled_card({{"length_mm", "length_mm = 0"}}));
  finds("set/card.toml:13: wire.length_mm = 0: must be");
  write("set/card.toml", filled_card({{"length_mm", "length_mm = 90"}}));
  finds("set/wire.toml: wire.length is 0.1 m, and card.toml has 0.09 m");
  write("set/wire.toml", "based_on = \"../card.toml\"\n");
  finds("set/wire.toml: has based_on");
  fs::remove(path("set/wire.toml"));
  finds("set/wire.toml: is missing");
  finds("set/wire.toml: is in SHA256SUMS, and is no file of the folder");
  write("set/SHA256SUMS", "nonsense\n" + std::string(64, '0') + "  ../a.csv\n" +
                              std::string(64, '0') + "  runs/none.csv\n");
  finds("set/SHA256SUMS:1: 'nonsense': must be 64 hexadecimal digits");
  finds("has ../a.csv, which is outside of the folder; it is not read");
  finds("set/runs/none.csv: is in SHA256SUMS, and is no file of the folder");
  finds("faults, named above");
  fs::remove_all(path("set/runs"));
  finds("set/runs: has no run");
  const Finished none = check("nowhere");
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.err, HasSubstr("--check nowhere: there is no such folder"));
  EXPECT_THAT(check("a.csv").err, HasSubstr("is a file and no folder"));
}

TEST_F(RecordCommand, NothingIsAddedThroughALink) {
  made({"a.csv"});
  fs::rename(path("set/runs"), path("elsewhere"));
  fs::create_directory_symlink("../elsewhere", path("set/runs"));
  refuses({"a.csv", "--run", "b"}, "--out set: has no folder runs, or a link in its place");
}

TEST_F(RecordCommand, MoreRowsThanWereConvertedAreNoted) {
  write("card.toml", filled_card({{"rate_Hz", "rate_Hz = 5"}}));
  const Finished f = record({"a.csv"});
  EXPECT_EQ(f.status, 0);
  EXPECT_THAT(f.err, HasSubstr("a.csv: has 10 rows/s, and by the card 5 Hz were converted"));
  EXPECT_THAT(check().err, HasSubstr("set/runs/a.csv: has 10 rows/s"));
}

// Nothing outside of the folder is opened: not even a pipe, which would wait for ever.
TEST_F(RecordCommand, ChecksFollowNoLinks) {
  made({"a.csv"});
  fs::rename(path("set/runs/a.csv"), path("outside.csv"));
  fs::create_symlink("../../outside.csv", path("set/runs/a.csv"));
  fs::create_directory_symlink("..", path("set/up"));
  mkfifo(path("set/runs/pipe.csv").c_str(), 0666);
  finds("set/runs/a.csv: is a link");
  finds("set/up: is a link");
  finds("set/runs/pipe.csv: is neither a file nor a folder");
  finds("set/runs: has no run");
  fs::remove(path("set/card.toml"));
  fs::create_symlink("../card.toml", path("set/card.toml"));
  finds("set/card.toml: is a link");
  refuses({"a.csv"}, "is a link; a data set holds its files itself");
}

TEST_F(RecordCommand, WhatIsPrintedIsEscaped) {
  made({"a.csv"});
  write("set/\x1B[2Jx\n.csv", "");
  fs::create_symlink("x", path("set/runs/\x1B[2J"));
  const Finished f = check();
  EXPECT_EQ(f.err.find('\x1B'), std::string::npos);
  EXPECT_THAT(f.err, HasSubstr("\\x1B[2J"));
}

}  // namespace
}  // namespace smaservo::test::record_test

// Files as people hand them in by mistake, each made of a good recording by one change: what the
// programs then say, and whether they go on.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "tests/host-sim/program.hpp"

namespace smaservo::test::bad_files_test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double length_m = 0.1;

/// A table of numbers, a column each.
class Table {
 public:
  /// A recording of the project, every fifth row, with a displacement in place of the strain.
  static Table good() {
    std::ifstream file(source_folder() + "/host-sim/traces/100MPa.csv");
    Table table;
    table.names = {"time_s", "current_A", "voltage_V", "load_N", "displacement_mm"};
    table.columns.resize(table.names.size());
    std::string line;
    std::getline(file, line);
    for (int i = 0; std::getline(file, line); ++i) {
      if (i % 5 != 0) {
        continue;
      }
      std::istringstream fields(line);
      std::string field;
      for (auto& column : table.columns) {
        std::getline(fields, field, ',');
        column.push_back(std::stod(field));
      }
    }
    table.change("displacement_mm",
                 [](double strain) { return 1e3 * length_m * (0.045 - strain); });
    return table;
  }

  std::vector<double>& of(const std::string& name) {
    const auto found = std::ranges::find(names, name);
    return columns.at(static_cast<std::size_t>(found - names.begin()));
  }
  Table& change(const std::string& name, const std::function<double(double)>& by) {
    std::ranges::transform(of(name), of(name).begin(), by);
    return *this;
  }
  Table& times(const std::string& name, double factor) {
    return change(name, [factor](double value) { return factor * value; });
  }
  Table& rename(const std::string& from, const std::string& to) {
    std::ranges::replace(names, from, to);
    return *this;
  }
  Table& drop(const std::string& name) {
    const auto found = std::ranges::find(names, name);
    columns.erase(columns.begin() + (found - names.begin()));
    names.erase(found);
    return *this;
  }
  /// The voltage of another resistance, of each row's own and its number.
  Table& resistance(const std::function<double(double ohm, std::size_t row)>& by) {
    for (std::size_t i = 0; i < of("voltage_V").size(); ++i) {
      const double current_A = of("current_A")[i];
      of("voltage_V")[i] = current_A * by(of("voltage_V")[i] / current_A, i);
    }
    return *this;
  }

  std::string text(char separator = ',') const {
    std::string text;
    for (const std::string& name : names) {
      text += (text.empty() ? "" : std::string(1, separator)) + name;
    }
    for (std::size_t i = 0; i < columns.front().size(); ++i) {
      for (std::size_t k = 0; k < columns.size(); ++k) {
        text += fmt::format("{}{:.12g}", k == 0 ? '\n' : separator, columns[k][i]);
      }
    }
    return text + "\n";
  }

  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
};

/// What the commands do with a file.
enum class Verdict : unsigned char { refused, warned };

struct BadFile {
  const char* what;
  Verdict verdict;
  std::function<std::string(Table)> make;
  std::vector<std::string> says;  ///< parts of the message
  Program::Texts options;
};

std::string with_line(std::string text, int number, const std::string& line) {
  std::size_t at = 0;
  for (int i = 1; i < number; ++i) {
    at = text.find('\n', at) + 1;
  }
  return text.replace(at, text.find('\n', at) - at, line);
}

/// Units and columns that are not what their names say.
std::vector<BadFile> wrong_units() {
  return {
      {"amperes in mA",
       Verdict::refused,
       [](Table t) { return t.rename("current_A", "current_mA").text(); },
       {"NiTi has 0.5 to 1.5",
        "column 2 'current_mA' is probably in A and not in mA: --column current=2:A"},
       {}},
      {"milliamperes in A",
       Verdict::refused,
       [](Table t) { return t.times("current_A", 1e3).text(); },
       {"column 2 'current_A' is probably in mA and not in A: --column current=2:mA"},
       {}},
      {"volts in mV",
       Verdict::refused,
       [](Table t) { return t.rename("voltage_V", "voltage_mV").text(); },
       {"column 3 'voltage_mV' is probably in V and not in mV: --column voltage=3:V"},
       {}},
      {"millivolts in V",
       Verdict::refused,
       [](Table t) { return t.times("voltage_V", 1e3).text(); },
       {"column 3 'voltage_V' is probably in mV and not in V: --column voltage=3:mV"},
       {}},
      {"milliamperes and millivolts in A and V",
       Verdict::refused,
       [](Table t) { return t.times("current_A", 1e3).times("voltage_V", 1e3).text(); },
       {"would heat the wire by", "--column current=2:mA --column voltage=3:mV"},
       {}},
      {"current and voltage swapped",
       Verdict::refused,
       [](Table t) {
         std::swap(t.of("current_A"), t.of("voltage_V"));
         return t.text();
       },
       {"columns 2 'current_A' and 3 'voltage_V' are probably swapped: --column current=3:A "
        "--column voltage=2:V"},
       {}},
      {"milliseconds in s",
       Verdict::refused,
       [](Table t) { return t.times("time_s", 1e3).text(); },
       {"come at least 20 s after the one before",
        "if column 1 'time_s' is in ms: --column time=1:ms"},
       {}},
      {"microseconds in s",
       Verdict::refused,
       [](Table t) { return t.times("time_s", 1e6).text(); },
       {"--column time=1:"},
       {}},
      {"seconds in us",
       Verdict::refused,
       [](Table t) { return t.rename("time_s", "time_us").text(); },
       {"all 3000 rows are within 6e-05 s", "--column time=1:ms"},
       {}},
      {"grams in N",
       Verdict::refused,
       [](Table t) { return t.times("load_N", 1 / 9.80665e-3).text(); },
       {"and above 1500 MPa a wire breaks",
        "column 4 'load_N' is probably in grams: --column load=4:gf"},
       {}},
      {"counts of a converter in N",
       Verdict::refused,
       [](Table t) {
         return t.change("load_N", [](double N) { return std::round(8388608 + 20000 * N); }).text();
       },
       {"counts of a converter", "--column load_N=4*NEWTONS_PER_COUNT"},
       {}},
      {"newtons in grams",
       Verdict::warned,
       [](Table t) { return t.rename("load_N", "load_gf").text(); },
       {"the load is at most", "probably in N: --column load=4:N"},
       {}},
      {"a load cell that is not connected",
       Verdict::warned,
       [](Table t) { return t.times("load_N", 0).text(); },
       {"is the load cell connected"},
       {}},
      {"a load cell the wrong way round",
       Verdict::refused,
       [](Table t) { return t.times("load_N", -1).text(); },
       {"the wire is pushed by", "--column load_N=4*-1"},
       {}},
      {"millimetres in m",
       Verdict::refused,
       [](Table t) { return t.rename("displacement_mm", "displacement_m").text(); },
       {"no wire survives more than",
        "column 5 'displacement_m' is probably in mm: --column displacement=5:mm"},
       {}},
      {"metres in mm",
       Verdict::refused,
       [](Table t) { return t.times("displacement_mm", 1e-3).text(); },
       {"the wire moves by",
        "column 5 'displacement_mm' is probably in m: --column displacement=5:m"},
       {}},
      {"a displacement that falls where the wire contracts",
       Verdict::refused,
       [](Table t) { return t.times("displacement_mm", -1).text(); },
       {"the wire gets longer where it is heated", "--column displacement_mm=5*-1"},
       {}},
      {"per cent of strain as a fraction",
       Verdict::refused,
       [](Table t) {
         return t.change("displacement_mm", [](double mm) { return 4.5 - mm; })
             .rename("displacement_mm", "strain_ref")
             .text();
       },
       {"line 2, column 5 (strain_ref)", "per cent are strain_ref_percent"},
       {}},
      {"a shunt the wrong way round",
       Verdict::refused,
       [](Table t) { return t.times("current_A", -1).text(); },
       {"voltage and current have opposite signs", "--column current_A=2*-1"},
       {}},
      {"kelvin in degC",
       Verdict::refused,
       [](Table t) {
         return t.drop("current_A")
             .drop("voltage_V")
             .rename("time_s", "temperature_degC")
             .change("temperature_degC", [](double s) { return 300 + s; })
             .text();
       },
       {"are they K in a column of degC?", "--column temperature=1:K"},
       {}},
      {"degC in K",
       Verdict::refused,
       [](Table t) {
         return t.drop("current_A")
             .drop("voltage_V")
             .rename("time_s", "temperature_K")
             .change("temperature_K", [](double s) { return 60 + s; })
             .text();
       },
       {"are they degC in a column of K?", "--column temperature=1:degC"},
       {}},
      {"2500 mA in A",
       Verdict::refused,
       [](Table t) { return t.times("current_A", 1e5).text(); },
       {"is out of range, -1000 to 1000 A; if it is in mA: --column current=2:mA"},
       {}},
  };
}

/// The wire, its leads, its sensors.
std::vector<BadFile> wrong_wires() {
  return {
      {"a tenth of the length",
       Verdict::refused,
       [](const Table& t) { return t.text(); },
       {"for 10 mm of 76 um wire; NiTi has 0.5 to 1.5", "mm long (--set wire.length_mm="},
       {"--set", "wire.length_mm=10"}},
      {"another diameter",
       Verdict::refused,
       [](const Table& t) { return t.text(); },
       {"of 50 um wire", "um thick (--set wire.diameter_um="},
       {"--set", "wire.diameter_um=50"}},
      {"two wires in place of four",
       Verdict::warned,
       [](Table t) { return t.resistance([](double ohm, std::size_t) { return ohm + 8; }).text(); },
       {"take off their resistance: replay --set measurement.lead_resistance_ohm="},
       {}},
      {"two long and thin wires in place of four",
       Verdict::refused,
       [](Table t) {
         return t.resistance([](double ohm, std::size_t) { return ohm + 30; }).text();
       },
       {"leads and clamps may have been measured with it, in place of four wires"},
       {}},
      {"copper",
       Verdict::refused,
       [](Table t) {
         double warm = 0;
         const std::vector<double> current = t.of("current_A");
         return t
             .resistance([&](double, std::size_t row) {
               warm += 0.03 * (current[row] * current[row] / 0.017 - warm);
               return 18 * (1 + 0.4 * warm);
             })
             .text();
       },
       {"the resistance rises from", "copper, steel or tungsten"},
       {}},
      {"nichrome",
       Verdict::refused,
       [](Table t) {
         t.times("current_A", 1.8);
         return t
             .resistance([](double, std::size_t row) {
               return 20 + 0.01 * std::sin(static_cast<double>(row));
             })
             .text();
       },
       {"the resistance changes by", "nichrome and constantan stay the same"},
       {}},
      {"a clipped voltage",
       Verdict::refused,
       [](Table t) {
         return t.change("voltage_V", [](double V) { return std::min(V, 1.0); }).text();
       },
       {"voltage stands still at 1 V for", "column 3 'voltage_V'",
        "record again with a wider range"},
       {}},
      {"a clipped current",
       Verdict::refused,
       [](Table t) {
         return t.change("current_A", [](double A) { return std::min(A, 0.05); }).text();
       },
       {"current stands still at 0.05 A for", "column 2 'current_A'"},
       {}},
      {"a displacement sensor at its stop",
       Verdict::refused,
       [](Table t) {
         return t.change("displacement_mm", [](double mm) { return std::max(mm, 1.5); }).text();
       },
       {"strain stands still at", "column 5 'displacement_mm'", "the sensor at a stop"},
       {}},
      {"voltage measured after the current",
       Verdict::warned,
       [](Table t) {
         // A square wave, whose voltage is that of three tenths of a step later.
         const std::vector<double> measured = t.of("voltage_V");
         auto& current = t.of("current_A");
         auto& voltage = t.of("voltage_V");
         for (std::size_t i = 0; i < current.size(); ++i) {
           voltage[i] /= current[i];
           current[i] = i / 40 % 2 == 0 ? 0.04 : 0.11;
         }
         for (std::size_t i = 0; i < current.size(); ++i) {
           const double next = current[std::min(i + 1, current.size() - 1)];
           voltage[i] *= current[i] + 0.3 * (next - current[i]);
         }
         return t.text();
       },
       {"the voltage was measured about 6 ms after the current"},
       {}},
      {"no heating",
       Verdict::warned,
       [](Table t) {
         t.resistance([](double, std::size_t) { return 22; });
         for (std::size_t i = 0; i < t.of("current_A").size(); ++i) {
           t.of("current_A")[i] = 0.012;
           t.of("voltage_V")[i] = 0.264;
         }
         return t.text();
       },
       {"the wire is never heated"},
       {}},
  };
}

/// What is no table of the right columns and numbers.
std::vector<BadFile> wrong_tables() {
  return {
      {"nothing", Verdict::refused, [](const Table&) { return std::string(); }, {"is empty"}, {}},
      {"a header alone",
       Verdict::refused,
       [](const Table&) { return std::string("time_s,current_A,voltage_V,load_N\n"); },
       {"has no usable row"},
       {}},
      {"a column that has two names",
       Verdict::refused,
       [](Table t) { return t.rename("load_N", "current_mA").text(); },
       {"column 4 (current_mA): there is another column for current"},
       {}},
      {"a unit that is none of current's",
       Verdict::refused,
       [](Table t) { return t.rename("current_A", "current_V").text(); },
       {"column 2 (current_V): current has no unit, or an unknown one; known are: current_A, "
        "current_mA"},
       {}},
      {"noise",
       Verdict::refused,
       [](const Table&) {
         std::string text;
         for (int i = 0; i < 5000; ++i) {
           text += static_cast<char>((i * 7919 + i * i) % 251);
         }
         return text;
       },
       {"run.csv"},
       {}},
      {"a zip archive",
       Verdict::refused,
       [](const Table&) { return std::string("PK\x03\x04 x"); },
       {"run.csv"},
       {}},
      {"names without units",
       Verdict::refused,
       [](Table t) { return t.rename("current_A", "I").rename("voltage_V", "U").text(); },
       {"--column current=2:A", "--column voltage=3:V"},
       {}},
      {"two columns of voltage",
       Verdict::refused,
       [](Table t) {
         return t.rename("voltage_V", "U [V]").rename("load_N", "Spannung [V]").text();
       },
       {"column 4 ('Spannung [V]') is one of several that may be the voltage, so say which"},
       {}},
  };
}

/// Rows that are bad by themselves: replay refuses the first one.
std::vector<BadFile> wrong_rows() {
  return {
      {"a reading that is not a number",
       Verdict::refused,
       [](const Table& t) { return with_line(t.text(), 101, "1.98,nan,0.3,0.45,0.5"); },
       {"line 101, column 2 (current_A): 'nan' is not a finite number"},
       {}},
      {"a word",
       Verdict::refused,
       [](const Table& t) { return with_line(t.text(), 77, "1.5,0.012,OVERLOAD,0.45,0.5"); },
       {"line 77, column 3 (voltage_V): 'OVERLOAD' is not a finite number"},
       {}},
      {"an empty field",
       Verdict::refused,
       [](const Table& t) { return with_line(t.text(), 77, "1.5,0.012,,0.45,0.5"); },
       {"line 77, column 3 (voltage_V): the field is empty"},
       {}},
      {"a decimal comma among commas",
       Verdict::refused,
       [](const Table& t) { return with_line(t.text(), 77, "1,5,0,012,0,27,0,45,0,5"); },
       {"line 77", "the row has 10 columns, the header 5"},
       {}},
      {"a line of too few fields",
       Verdict::refused,
       [](const Table& t) { return with_line(t.text(), 77, "1.5,0.012"); },
       {"line 77", "the row has 2 columns, the header 5"},
       {}},
      {"a clock that falls back",
       Verdict::refused,
       [](const Table& t) { return with_line(t.text(), 77, "0.1,0.012,0.27,0.45,0.5"); },
       {"line 77, column 1 (time_s): time 0.1 s does not come after 1.48 s"},
       {}},
  };
}

void expect(const BadFile& bad, const Program::Texts& command) {
  SCOPED_TRACE(std::string(bad.what) + ": " + command.front());
  Program program;
  program.folder().write("run.csv", bad.make(Table::good()));
  Program::Texts words = command;
  words.insert(words.end(), bad.options.begin(), bad.options.end());
  const Finished f = program.run(words);
  if (bad.verdict == Verdict::refused) {
    EXPECT_EQ(f.status, 1) << f.out << f.err;
  } else {
    EXPECT_THAT(f.status, AnyOf(0, 3)) << f.err;  // the observers may be lost all the same
  }
  // Paragraphs of `inspect` are broken into lines.
  std::string said = f.out + f.err;
  for (std::size_t at = 0; (at = said.find("\n            ", at)) != std::string::npos;) {
    said.replace(at, 13, " ");
  }
  for (const std::string& part : bad.says) {
    EXPECT_THAT(said, HasSubstr(part));
  }
}

TEST(BadFiles, AGoodOneHasNoMistakes) {
  Program program;
  program.folder().write("run.csv", Table::good().text());
  const Finished f = program.run({"replay", "run.csv"});
  EXPECT_EQ(f.status, 0);
  // Every complaint names the file. Progress, which a slow machine tells after ten seconds, does
  // not.
  EXPECT_THAT(f.err, Not(HasSubstr("run.csv")));
  const Finished inspected = program.run({"inspect", "--wire", "smartflex-76um", "run.csv"});
  EXPECT_EQ(inspected.status, 0);
  EXPECT_THAT(inspected.out, AllOf(Not(HasSubstr("mistake")), Not(HasSubstr("note"))));
}

TEST(BadFiles, AreNamedByReplayAndInspect) {
  std::size_t count = 0;
  for (const auto& files : {wrong_units(), wrong_wires(), wrong_tables()}) {
    for (const BadFile& bad : files) {
      expect(bad, {"replay", "run.csv"});
      if (std::string_view(bad.what).find("columns of voltage") == std::string_view::npos &&
          std::string_view(bad.what) != "names without units") {
        expect(bad, {"inspect", "--wire", "smartflex-76um", "run.csv"});
      }
      ++count;
    }
  }
  for (const BadFile& bad : wrong_rows()) {
    expect(bad, {"replay", "run.csv"});
    ++count;
  }
  EXPECT_GE(count, 40U);
}

/// Before a fit begins, which takes minutes.
TEST(BadFiles, AreNamedByIdentify) {
  for (const auto& files : {wrong_units(), wrong_wires(), wrong_tables(), wrong_rows()}) {
    for (const BadFile& bad : files) {
      if (bad.verdict == Verdict::refused) {
        expect(bad, {"identify", "--out", "w.toml", "run.csv"});
      }
    }
  }
}

TEST(BadFiles, WhatIsAllowedIsAWarning) {
  Program program;
  Table table = Table::good();
  program.folder().write("run.csv", table.times("current_A", 1e3).text());
  const Finished f = program.run({"replay", "run.csv", "--allow", "resistivity"});
  EXPECT_THAT(f.err, HasSubstr("NiTi has 0.5 to 1.5"));
  EXPECT_THAT(program.run({"replay", "run.csv", "--allow", "everything"}).err,
              HasSubstr("--allow everything: there is no such check; there are: alloy, clipped"));
}

TEST(BadFiles, TheOptionThatIsNamedMendsThem) {
  const std::pair<std::string, Program::Texts> mended[] = {
      {Table::good().times("current_A", 1e3).text(), {"--column", "current=2:mA"}},
      {Table::good().times("time_s", 1e3).text(), {"--column", "time=1:ms"}},
      {Table::good().times("load_N", 1 / 9.80665e-3).text(), {"--column", "load=4:gf"}},
      {Table::good().times("displacement_mm", -1).text(), {"--column", "displacement_mm=5*-1"}},
      {Table::good().times("current_A", 1e3).times("voltage_V", 1e3).text(),
       {"--column", "current=2:mA", "--column", "voltage=3:mV"}}};
  Program program;
  program.folder().write("run.csv", Table::good().text());
  const auto of_kalman = [](const std::string& table) {
    return table.substr(table.find("kalman"), table.find("open-loop") - table.find("kalman"));
  };
  const std::string good = of_kalman(program.run({"replay", "run.csv"}).out);
  for (const auto& [text, options] : mended) {
    program.folder().write("run.csv", text);
    Program::Texts words{"replay", "run.csv"};
    words.insert(words.end(), options.begin(), options.end());
    const Finished f = program.run(words);
    EXPECT_EQ(f.status, 0) << f.err;
    EXPECT_EQ(of_kalman(f.out), good) << options.back();
  }
}

}  // namespace
}  // namespace smaservo::test::bad_files_test

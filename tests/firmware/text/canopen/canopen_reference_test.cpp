#include "firmware/text/canopen/canopen_reference.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>
#include <set>
#include <sstream>

#include "firmware/text/canopen/object_list.hpp"
#include "firmware/text/canopen/parameter_reference.hpp"
#include "tests/can/eds_node/eds_file.hpp"
#include "tests/firmware/canopen/servo/servo_rig.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using canopen::Abort;
using testing::HasSubstr;
using testing::Not;

/// Anew: build/release/host-sim/host-sim describe eds > firmware/reference/smaservo.eds, likewise
/// dbc and objects (OBJECTS.md).
TEST(CanopenReference, TheFilesAreUpToDate) {
  const std::string folder = test::source_folder() + "/firmware/reference/";
  EXPECT_EQ(file_text(folder + "smaservo.eds"), text::eds_text());
  EXPECT_EQ(file_text(folder + "smaservo.dbc"), text::dbc_text());
  EXPECT_EQ(file_text(folder + "OBJECTS.md"), text::object_reference());
}

TEST(CanopenReference, EveryObjectIsInOneOfTheTwoPages) {
  const std::string objects = text::object_reference();
  const std::string parameters = text::parameter_reference();
  for (const text::ListedIndex& listed : text::list_objects()) {
    for (const text::ListedObject& object : listed.objects) {
      const Key key = object.object.key;
      const std::string row = fmt::format("\n| {:04X}h:{} | ", key.index, key.sub);
      EXPECT_NE(objects.find(row) == std::string::npos, parameters.find(row) == std::string::npos)
          << row;
    }
  }
}

TEST(CanopenReference, TheDataSheetAvoidsWhatReadersStumbleOver) {
  const std::string text = text::eds_text();
  EXPECT_THAT(text, Not(HasSubstr("=\n"))) << "an empty key";
  EXPECT_THAT(text, Not(HasSubstr("rwr")));
  for (const char* section : {"[FileInfo]", "[DeviceInfo]", "[DummyUsage]", "[MandatoryObjects]",
                              "[OptionalObjects]", "[ManufacturerObjects]"}) {
    EXPECT_THAT(text, HasSubstr(section));
  }
}

/// What the data sheet says of an object is what the node does: it exists, it reads as its default,
/// its access is refused where it should be, a PDO takes it where it may.
TEST(CanopenReference, TheNodeIsAsTheDataSheetSays) {
  canopen::ServoRig rig;
  rig.staging.restart(default_settings<double>());
  rig.restart();
  const Eds eds =
      parse_eds(text::eds_text(text::RealDefaults::decimal), "smaservo.eds", canopen::ServoRig::id);
  EXPECT_LT(400U, eds.objects.size());
  std::set<Key> without_default;
  for (const text::ListedIndex& listed : text::list_objects()) {
    for (const text::ListedObject& object : listed.objects) {
      if (!object.has_default) {
        without_default.insert(object.object.key);
      }
    }
  }
  for (const EdsObject& object : eds.objects) {
    canopen::Entry entry{};
    ASSERT_EQ(rig.servo.node().find(object.key, entry), Abort::none)
        << std::hex << object.key.index << ' ' << int{object.key.sub};
    EXPECT_EQ(entry.type, object.type) << object.name;
    const unsigned rights = canopen::readable | canopen::writable;
    EXPECT_EQ(entry.access & rights, object.access & rights) << object.name;
    EXPECT_EQ((entry.access & (canopen::in_rpdo | canopen::in_tpdo)) != 0,
              (object.access & (canopen::in_rpdo | canopen::in_tpdo)) != 0)
        << object.name;
    // What is read-only is measured, but for these two.
    const bool is_given = (object.access & canopen::writable) != 0 ||
                          object.key == Key{0x6502, 0} || object.key == Key{0x2003, 1};
    const bool compares = (object.access & canopen::readable) != 0 && is_given &&
                          canopen::size_of(object.type) != 0 &&
                          !without_default.contains(object.key);
    if (compares) {
      EXPECT_EQ(rig.upload(object.key).data, object.standard)
          << object.name << std::hex << ' ' << object.key.index;
    }
  }
}

std::vector<std::string> sections_of_reals(const std::string& eds) {
  std::vector<std::string> all;
  for (std::size_t at = eds.find("DataType=0x0008"); at != std::string::npos;
       at = eds.find("DataType=0x0008", at + 1)) {
    all.push_back(eds.substr(at, eds.find("\n\n", at) - at));
  }
  return all;
}

TEST(CanopenReference, RealsHaveDefaultsWhereTheyAreAskedForOnly) {
  const std::vector<std::string> plain = sections_of_reals(text::eds_text());
  EXPECT_GT(plain.size(), 200U);
  for (const std::string& section : plain) {
    EXPECT_THAT(section, Not(HasSubstr("\nDefaultValue="))) << section;
  }
  for (const std::string& section :
       sections_of_reals(text::eds_text(text::RealDefaults::decimal))) {
    EXPECT_THAT(section, HasSubstr("\nDefaultValue=")) << section;
  }
}

/// Lely's dcfgen, which ros2_canopen runs, takes no other values (dcf-tools 2.4, dcf/device.py and
/// dcf/lint.py: a sign, decimal or hexadecimal digits, behind $NODEID+ where it has that). It is
/// not in Debian, so that its rule stands here.
TEST(CanopenReference, EachValueIsOneThatLelyReads) {
  const std::regex value(R"(\s*(\$NODEID\s*\+\s*)?((-?0x[0-9A-F]+)|(-?[0-9]+)))",
                         std::regex::icase);
  std::istringstream text(text::eds_text());
  std::string type;
  int values = 0;
  for (std::string line; std::getline(text, line);) {
    const std::string key = line.substr(0, line.find('='));
    const std::string said = line.substr(std::min(line.find('=') + 1, line.size()));
    type = key == "DataType" ? said : type;
    const bool is_text = type == "0x0009" || type == "0x000A" || type == "0x000F";
    if ((key == "DefaultValue" || key == "LowLimit" || key == "HighLimit") && !is_text) {
      EXPECT_TRUE(std::regex_match(said, value)) << line;
      ++values;
    }
  }
  EXPECT_GT(values, 200);
}

TEST(CanopenReference, NothingIsServedThatTheDataSheetDoesNotTell) {
  canopen::ServoRig rig;
  const Eds eds = parse_eds(text::eds_text(), "smaservo.eds", canopen::ServoRig::id);
  auto known = eds.objects.begin();
  for (unsigned index = 0x1000; index <= 0x6FFF; ++index) {
    for (unsigned sub = 0; sub < 32; ++sub) {
      const Key key{static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub)};
      while (known != eds.objects.end() && known->key < key) {
        ++known;
      }
      canopen::Entry entry{};
      const bool served = rig.servo.node().find(key, entry) == Abort::none;
      EXPECT_EQ(served, known != eds.objects.end() && known->key == key)
          << std::hex << index << ' ' << sub;
    }
  }
}

}  // namespace
}  // namespace smaservo::test

// What was written over the bus, as sentences.

#include "firmware/daemon/bus/bus_journal.hpp"

#include <gtest/gtest.h>
#include <vector>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::test::bus_journal_test {
namespace {

using canopen::Abort;
using canopen::as_bits;
using canopen::LoggedChange;
using canopen::Source;

constexpr Key gain{0x2100, 1};

/// The texts of a journal that has ended, after `count` changes of which it was given only these.
std::vector<std::string> said(const std::vector<LoggedChange>& changes, std::size_t count) {
  std::vector<std::string> texts;
  {
    daemon::BusJournal journal([&](const std::string& text) { texts.push_back(text); });
    for (const LoggedChange& change : changes) {
      journal.add(change);
    }
    journal.set_count(static_cast<std::uint32_t>(count));
  }
  return texts;
}

TEST(BusJournal, SaysOldNewAndSource) {
  const std::vector<LoggedChange> changes{
      {0, gain, Source::sdo, as_bits(0.F), as_bits(0.5F), Abort::none},
      {0, gain, Source::sdo, as_bits(0.5F), 0x7FC0'0000, Abort::value},
      {0, {0x2201, 1}, Source::rpdo, as_bits(0.F), as_bits(26.F), Abort::too_high},
      {0, gain, Source::sdo, as_bits(0.5F), 0x7, Abort::too_short},
      {0, {0x6060, 0}, Source::sdo, 1, 9, Abort::value},
      {0, {0x2102, 1}, Source::device, 2, 4, Abort::none},
      {0, {0x2102, 1}, Source::sdo, 0, 2, Abort::state},
      // "smas"; an escape sequence that empties a terminal; a line break.
      {0, {0x1008, 0}, Source::sdo, 0x73616D73, 0x4A325B1B, Abort::read_only},
      {0, {0x1008, 0}, Source::sdo, 0x73616D73, 0x6B6F0A61, Abort::read_only},
  };
  const std::string gain_stays = "strain.proportional_W (2100h:1): stays 0.5; ";
  const std::string not_allowed = " by SDO is refused: value not allowed (abort 06090030h)";
  const std::string device_name = "Manufacturer device name (1008h:0): stays smas; ";
  const std::string read_only = " by SDO is refused: cannot be written (abort 06010002h)";
  const std::vector<std::string> expected{
      "strain.proportional_W (2100h:1): 0 -> 0.5, by SDO",
      gain_stays + "nan" + not_allowed,
      "target.current_A (2201h:1): stays 0; 26 by PDO is refused: value too high (abort 06090031h)",
      gain_stays + "7h by SDO is refused: too short (abort 06070013h)",
      "Modes of operation (6060h:0): stays 1; 9" + not_allowed,
      "tuning: the client has gone, all is reverted",
      "tuning: try is refused: not in the present state of the device (abort 08000022h)",
      device_name + "\\x1B[2J" + read_only,
      device_name + "a\\x0Aok" + read_only,
  };
  EXPECT_EQ(said(changes, changes.size()), expected);
}

// Changes that are not listed are counted, so that none is lost in silence and a log cannot fill
// the disk.
TEST(BusJournal, CountsWhatItDoesNotSay) {
  const LoggedChange change{0, gain, Source::sdo, 0, 1, Abort::none};
  std::vector<std::string> texts = said(std::vector<LoggedChange>(100, change), 100);
  ASSERT_EQ(texts.size(), daemon::BusJournal::max_at_once + 1);
  EXPECT_EQ(texts.back(), "80 more changes and refusals, which are not listed");
  texts = said({change}, 8);
  ASSERT_EQ(texts.size(), 2U);
  EXPECT_EQ(texts.back(), "7 more changes and refusals, which are not listed");
}

}  // namespace
}  // namespace smaservo::test::bus_journal_test

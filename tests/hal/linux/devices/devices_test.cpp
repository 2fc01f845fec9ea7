// Linux devices on a made-up tree of the kernel's files, and on converters of the test's.

#include <array>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

#include "firmware/parameters/store/store.hpp"
#include "hal/linux/board.hpp"
#include "hal/linux/devices/ads131m04_digitizer.hpp"
#include "hal/linux/devices/iio.hpp"
#include "hal/linux/system/file_store.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/hal/linux/devices/kernel_tree.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::devices_test {
namespace {

namespace fs = std::filesystem;
namespace ads = hal::ads131m04;

TEST(Ads131m04, CommandsAndRegistersAreThoseOfTheDataSheet) {
  // Table 8-11: 101a aaaa annn nnnn reads, 011a aaaa annn nnnn writes; reset values of the
  // registers.
  EXPECT_EQ(ads::read_command(ads::Register::id), 0xA000);
  EXPECT_EQ(ads::read_command(ads::Register::clock), 0xA180);
  EXPECT_EQ(ads::write_command(ads::Register::mode), 0x6100);
  EXPECT_EQ(ads::write_response(ads::Register::gain), 0x4200);
  EXPECT_EQ(ads::clock_register(3), 0x0F0E);
  EXPECT_EQ(ads::gain_register({0, 1, 2, 7}), 0x7210);
  const ads::FrameBytes bytes = ads::command_frame(0x6180, 0x0F0E);
  EXPECT_EQ(bytes, (ads::FrameBytes{0x61, 0x80, 0, 0x0F, 0x0E, 0}));
  EXPECT_LE(ads::frame_bytes, 64U);
}

TEST(Ads131m04, TheCrcIsThatOfTheCcitt) {
  // The check value of CRC-16/IBM-3740, polynomial 1021h from FFFFh.
  constexpr std::array<std::uint8_t, 9> digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(ads::crc16(digits), 0x29B1);
}

ads::FrameBytes reply_of(std::uint16_t response, const std::array<std::int32_t, 4>& codes) {
  ads::FrameBytes bytes{};
  bytes[0] = static_cast<std::uint8_t>(response >> 8U);
  bytes[1] = static_cast<std::uint8_t>(response);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto word = static_cast<std::uint32_t>(codes.at(i));
    for (std::size_t b = 0; b < 3; ++b) {
      bytes.at(3 * (i + 1) + b) = static_cast<std::uint8_t>(word >> (16 - 8 * b));
    }
  }
  const std::uint16_t crc = ads::crc16(std::span(bytes).first(15));
  bytes[15] = static_cast<std::uint8_t>(crc >> 8U);
  bytes[16] = static_cast<std::uint8_t>(crc);
  return bytes;
}

TEST(Ads131m04, EveryFlippedBitIsFound) {
  const std::array<std::int32_t, 4> codes{0x7FFFFF, -0x800000, -1, 1};
  const ads::FrameBytes good = reply_of(0x050F, codes);
  ASSERT_TRUE(ads::parse(good));
  EXPECT_EQ(ads::parse(good)->codes, codes);
  EXPECT_EQ(ads::parse(good)->response, 0x050F);
  for (std::size_t bit = 0; bit < std::size_t{17} * 8; ++bit) {
    ads::FrameBytes bad = good;
    bad.at(bit / 8) ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_FALSE(ads::parse(bad)) << bit;
  }
}

/// The converter's side of the wires.
class FakeAds : public hal::SpiPort {
 public:
  struct State {
    std::uint16_t id = 0x2403;
    std::array<std::uint16_t, 16> registers{0, 0, 0x0510, 0x0F0E};
    std::array<std::int32_t, 4> codes{};
    bool fresh = true, was_reset = true, dead = false, garbled = false;
    std::uint16_t answer = 0xFF24;
    int frames = 0;
  };
  explicit FakeAds(State& state) : s_(state) {}

  bool transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) override {
    if (s_.dead) {
      return false;
    }
    ++s_.frames;
    const ads::FrameBytes reply = reply_of(s_.answer, s_.codes);
    std::ranges::copy(reply, in.begin());
    in[7] ^= s_.garbled ? 0x10 : 0;
    obey(static_cast<std::uint16_t>(out[0] << 8U | out[1]),
         static_cast<std::uint16_t>(out[3] << 8U | out[4]));
    return true;
  }

 private:
  void obey(std::uint16_t command, std::uint16_t value) {
    const std::size_t r = command >> 7U & 0x3FU;
    if (command >> 13U == 5) {
      s_.answer = r == 0 ? s_.id : s_.registers.at(r);
    } else if (command >> 13U == 3) {
      s_.registers.at(r) = value;
      s_.was_reset = r == 2 ? (value & 0x0400U) != 0 : s_.was_reset;
      s_.answer = static_cast<std::uint16_t>(0x4000U | r << 7U);
    } else {
      s_.answer = static_cast<std::uint16_t>(0x0100U | (s_.was_reset ? 0x0400U : 0U) |
                                             (s_.fresh ? 0xFU : 0U));
    }
  }
  State& s_;
};

TEST(Ads131m04Digitizer, SetsUpReadsAndRecovers) {
  FakeAds::State state;
  hal::Ads131m04Digitizer digitizer(std::make_unique<FakeAds>(state), "spi", {2, {0, 3, 0, 0}});
  EXPECT_EQ(state.registers[3], 0x0F0A);
  EXPECT_EQ(state.registers[4], 0x0030);
  EXPECT_EQ(state.registers[2], 0x0110);
  state.codes = {100, -200, 0x7FFFFF, -0x800000};
  hal::RawFrame raw{};
  ASSERT_TRUE(digitizer.read(raw));
  EXPECT_EQ(raw.codes[1], -200);
  EXPECT_EQ(raw.codes[3], -0x800000);
  const std::uint32_t sequence = raw.sequence;
  ASSERT_TRUE(digitizer.read(raw));
  EXPECT_EQ(raw.sequence, sequence + 1);
  state.garbled = true;
  EXPECT_FALSE(digitizer.read(raw));
  EXPECT_EQ(digitizer.damaged(), 2U);
  state.garbled = false;
  state.fresh = false;
  digitizer.read(raw);
  EXPECT_FALSE(digitizer.read(raw));
  state.fresh = true;
  // A dip of its supply: the settings have gone, and come back before a sample counts.
  digitizer.read(raw);
  state.was_reset = true;
  state.registers = {0, 0, 0x0510, 0x0F0E};
  digitizer.read(raw);
  for (int i = 0; i < 3 && !digitizer.read(raw); ++i) {
  }
  EXPECT_TRUE(digitizer.read(raw));
  EXPECT_EQ(state.registers[4], 0x0030);
  state.dead = true;
  EXPECT_FALSE(digitizer.read(raw));
}

TEST(Ads131m04Digitizer, RefusesWhatIsNone) {
  FakeAds::State other;
  other.id = 0x2203;
  EXPECT_THROW(hal::Ads131m04Digitizer(std::make_unique<FakeAds>(other), "spi", {}),
               hal::DeviceError);
  FakeAds::State dead;
  dead.dead = true;
  EXPECT_THROW(hal::Ads131m04Digitizer(std::make_unique<FakeAds>(dead), "spi", {}),
               hal::DeviceError);
}

TEST(IioScan, ReadsTheTypesThatTheKernelWrites) {
  EXPECT_EQ(hal::parse_scan_type("le:s24/32>>8"), (hal::ScanType{false, true, 24, 32, 8}));
  EXPECT_EQ(hal::parse_scan_type("be:u12/16>>4"), (hal::ScanType{true, false, 12, 16, 4}));
  EXPECT_EQ(hal::parse_scan_type("le:s64/64>>0"), (hal::ScanType{false, true, 64, 64, 0}));
  for (const char* bad : {"", "le:s24/32", "le:x24/32>>8", "s24/32>>8", "le:s24/24>>0",
                          "le:s33/32>>0", "le:s24/32>>9", "le:s16/16X2>>0", "le:s24/32>>8 "}) {
    EXPECT_FALSE(hal::parse_scan_type(bad)) << bad;
  }
}

/// As a converter does it.
void write_sample(const hal::PlacedElement& element, std::int64_t value,
                  std::span<std::byte> scan) {
  const hal::ScanType& t = element.type;
  std::uint64_t word = t.bits == 64
                           ? static_cast<std::uint64_t>(value)
                           : static_cast<std::uint64_t>(value) & ((std::uint64_t{1} << t.bits) - 1);
  word <<= t.shift;
  for (unsigned b = 0; b < t.storage / 8; ++b) {
    const unsigned at = t.big_endian ? t.storage / 8 - 1 - b : b;
    scan[element.offset + at] = static_cast<std::byte>(word >> (8 * b));
  }
}

TEST(IioScan, FindsEverySampleAgain) {
  // An independent writer of scans, on random types, orders and values.
  std::mt19937_64 random(11);
  constexpr std::array storages{8U, 16U, 32U, 64U};
  for (int round = 0; round < 500; ++round) {
    std::vector<hal::ScanElement> elements;
    std::vector<std::int64_t> values;
    const std::size_t count = 1 + random() % 6;
    std::vector<unsigned> indices(count);
    for (unsigned i = 0; i < count; ++i) {
      indices[i] = i;
    }
    std::ranges::shuffle(indices, random);
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned storage = storages.at(random() % 4);
      const unsigned bits = 1 + static_cast<unsigned>(random() % storage);
      const unsigned shift = static_cast<unsigned>(random() % (storage - bits + 1));
      elements.push_back(
          {"e", indices[i], {random() % 2 == 0, random() % 2 == 0, bits, storage, shift}});
      const std::uint64_t raw = random() >> (64 - bits);
      const bool negative = elements[i].type.is_signed && (raw >> (bits - 1) & 1U) != 0;
      values.push_back(negative && bits < 64
                           ? static_cast<std::int64_t>(raw - (std::uint64_t{1} << bits))
                           : static_cast<std::int64_t>(raw));
    }
    const hal::ScanLayout layout = hal::lay_out(elements);
    std::vector<std::byte> scan(layout.size);
    for (std::byte& byte : scan) {
      byte = static_cast<std::byte>(random());
    }
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(layout.elements[i].offset % (elements[i].type.storage / 8), 0U);
      write_sample(layout.elements[i], values[i], scan);
    }
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(hal::sample_of(layout.elements[i], scan), values[i]) << round;
    }
  }
}

TEST(Iio, SetsTheBufferUpAndTakesTheNewestScan) {
  const KernelTree tree;
  tree.adc();
  hal::IioSettings settings;
  settings.device = "ad7606";
  settings.channels = {"in_voltage2", "in_voltage0"};
  settings.trigger = "smaservo";
  hal::IioDigitizer digitizer(tree.roots(), settings);
  const std::string base = "sys/bus/iio/devices/iio:device3/";
  EXPECT_EQ(tree.text(base + "scan_elements/in_voltage1_en"), "0");
  EXPECT_EQ(tree.text(base + "scan_elements/in_voltage2_en"), "1");
  EXPECT_EQ(tree.text(base + "trigger/current_trigger"), "smaservo");
  EXPECT_EQ(tree.text(base + "buffer/length"), "16");
  EXPECT_EQ(tree.text(base + "buffer/enable"), "1");
  EXPECT_NEAR(digitizer.meanings().at(0).scale, 0.15258789, 1e-12);
  hal::RawFrame raw{};
  ASSERT_TRUE(digitizer.read(raw));
  EXPECT_EQ(raw.codes[1], 3);   // in_voltage0, the second scan
  EXPECT_EQ(raw.codes[0], -4);  // in_voltage2
  EXPECT_EQ(raw.sequence, 2U);
  EXPECT_FALSE(digitizer.read(raw)) << "no scan comes twice";
}

template <class Open>
std::string refusal(Open open) {
  try {
    open();
  } catch (const hal::DeviceError& error) {
    return error.what();
  }
  return "";
}

TEST(Iio, SaysWhatIsNotThere) {
  const KernelTree tree;
  tree.adc();
  const auto says = [&](hal::IioSettings settings) {
    return refusal([&] { hal::IioDigitizer(tree.roots(), settings); });
  };
  hal::IioSettings settings;
  settings.device = "mcp3911";
  settings.channels = {"in_voltage0"};
  EXPECT_NE(says(settings).find("none is called 'mcp3911'; there is: ad7606"), std::string::npos);
  settings.device = "ad7606";
  settings.channels = {"in_voltage9"};
  EXPECT_NE(says(settings).find("has no scan element in_voltage9"), std::string::npos);
  tree.put("sys/bus/iio/devices/iio:device3/scan_elements/in_voltage0_type", "le:s24\n");
  settings.channels = {"in_voltage0"};
  EXPECT_NE(says(settings).find("'le:s24' is no scan type"), std::string::npos);
}

TEST(OutputStage, NothingButAPositiveNumberGivesACurrent) {
  const hal::DacScale scale{10'000, 100, 4095};
  EXPECT_EQ(hal::dac_code(scale, {0.2, 0, 0}), 2100);
  EXPECT_EQ(hal::dac_code(scale, {9, 0, 0}), 4095);
  for (const double off : {0.0, -1.0, std::nan(""), -std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(hal::dac_code(scale, {off, 5, 0}), 100);
  }
}

// A second program finds out before it has told anything; who only wants it off may.
TEST(OutputStage, OneProcessAtATimeDrivesIt) {
  const KernelTree tree;
  const std::string pwm = "sys/class/pwm/pwmchip0/pwm0/";
  const std::string raw = "sys/bus/iio/devices/iio:device0/out_voltage0_raw";
  for (const char* const file : {"duty_cycle", "period", "enable"}) {
    tree.put(pwm + file, "");
  }
  tree.put("sys/bus/iio/devices/iio:device0/name", "ad5686\n");
  tree.put(raw, "");
  hal::LinuxRoots roots = tree.roots();
  const hal::PwmSettings chopper{"pwmchip0", 0, 50'000, 24, 0.9};
  const hal::IioDacSettings dac{"ad5686", "out_voltage0", {10'000, 0, 65535}};
  {
    hal::PwmDrive drive(roots, chopper);
    hal::IioDac source(roots, dac);
    ASSERT_TRUE(drive.put({0, 12, 0}));
    ASSERT_TRUE(source.put({0.4321, 0, 0}));
    EXPECT_THROW(hal::PwmDrive(roots, chopper), hal::DeviceBusy);
    EXPECT_THROW(hal::IioDac(roots, dac), hal::DeviceBusy);
    EXPECT_EQ(tree.text(pwm + "duty_cycle"), "25000");
    EXPECT_EQ(tree.text(raw), "4321");
    roots.takes_over = true;
    const hal::PwmDrive off(roots, chopper);
    EXPECT_EQ(tree.text(pwm + "duty_cycle").front(), '0');
    roots.takes_over = false;
  }
  EXPECT_NO_THROW(hal::PwmDrive(roots, chopper)) << "it has ended";
}

TEST(OutputStage, ThreeKindsAreToldAndSwitchedOff) {
  const KernelTree tree;
  tree.put("sys/bus/iio/devices/iio:device0/name", "ad5686\n");
  tree.put("sys/bus/iio/devices/iio:device0/out_voltage0_raw", "4444");
  hal::IioDac dac(tree.roots(), {"ad5686", "out_voltage0", {10'000, 0, 65535}});
  const std::string raw = "sys/bus/iio/devices/iio:device0/out_voltage0_raw";
  EXPECT_EQ(tree.text(raw).front(), '0') << "off before anything else";
  EXPECT_TRUE(dac.put({0.4321, 0, 0}));
  EXPECT_EQ(tree.text(raw), "4321");
  const hal::OffAction off = dac.off_action();
  hal::switch_off({&off, 1});
  EXPECT_EQ(tree.text(raw).front(), '0');

  tree.put("sys/class/pwm/pwmchip0/pwm1/duty_cycle", "99999");
  tree.put("sys/class/pwm/pwmchip0/pwm1/period", "");
  tree.put("sys/class/pwm/pwmchip0/pwm1/enable", "");
  hal::PwmDrive pwm(tree.roots(), {"pwmchip0", 1, 50'000, 24, 0.9});
  EXPECT_EQ(tree.text("sys/class/pwm/pwmchip0/pwm1/period"), "50000");
  const std::string duty = "sys/class/pwm/pwmchip0/pwm1/duty_cycle";
  EXPECT_TRUE(pwm.put({0, 12, 0}));
  EXPECT_EQ(tree.text(duty), "25000");
  EXPECT_TRUE(pwm.put({0, 24, 0}));
  EXPECT_EQ(tree.text(duty), "45000");
  EXPECT_TRUE(pwm.off());
  EXPECT_EQ(tree.text(duty).front(), '0');

  hal::SpiDacSettings spi{};
  spi.command = 0x300000;
  spi.shift = 4;
  EXPECT_EQ(hal::dac_frame(spi, 0xABC), (std::array<std::uint8_t, 3>{0x30, 0xAB, 0xC0}));
  spi.frame_bytes = 2;
  EXPECT_EQ(hal::dac_frame(spi, 0xABC), (std::array<std::uint8_t, 3>{0xAB, 0xC0, 0}));
}

TEST(SlowSensors, AFileThatGoesIsNoNumber) {
  const KernelTree tree;
  tree.put("sys/class/hwmon/hwmon0/temp1_input", "25000\n");
  const hal::SlowSensor air{"class/hwmon/hwmon0/temp1_input", 1e-3, 273150};
  const hal::SlowSensors sensors(tree.roots(), {hal::SlowSensor{}, air, hal::SlowSensor{}});
  EXPECT_DOUBLE_EQ(sensors.value(hal::SlowSensors::ambient), room_K);
  EXPECT_TRUE(std::isnan(sensors.value(hal::SlowSensors::supply)));
  const hal::SlowSensor missing{"class/hwmon/hwmon9/temp1_input", 1, 0};
  EXPECT_NE(refusal([&] { hal::SlowSensors(tree.roots(), {missing, air, air}); }).find("hwmon9"),
            std::string::npos);
}

TEST(FileStore, KeepsOneOfTwoSettingsWhateverIsLost) {
  static_assert(Storage<hal::FileStore>);
  const TemporaryFolder folder;
  Settings<double> settings = default_settings<double>();
  settings.wire = files::load_wire(std::string(files::default_wire)).wire;
  settings = stored_settings<double>(settings);
  {
    hal::FileStore store(folder / "");
    EXPECT_EQ(load_settings<double>(store).reason, LoadReason::none);
    EXPECT_EQ(load_settings<double>(store).slots[0].state, SlotState::empty);
    ASSERT_TRUE(save_settings(store, settings).ok());
    settings.limits.duty *= 0.5;
    settings = stored_settings<double>(settings);
    ASSERT_TRUE(save_settings(store, settings).ok());
  }
  hal::FileStore store(folder / "");
  const Loaded<double> loaded = load_settings<double>(store);
  EXPECT_EQ(loaded.reason, LoadReason::newer);
  EXPECT_EQ(loaded.slot, 0U) << "the first save has written both";
  EXPECT_TRUE(same_settings(loaded.settings, settings));
  EXPECT_FALSE(fs::exists(folder / "settings.0.part"));
  // Erased and written without sync(), as where power goes: the slot is what it was.
  ASSERT_TRUE(store.erase(1));
  hal::FileStore after(folder / "");
  EXPECT_EQ(load_settings<double>(after).slots[1].state, SlotState::valid);
  for (const std::uintmax_t size : {100U, 10U, 0U}) {
    fs::resize_file(folder / "settings.0", size);
    hal::FileStore damaged(folder / "");
    const Loaded<double> other = load_settings<double>(damaged);
    EXPECT_EQ(other.slot, 1U);
    EXPECT_EQ(other.reason, LoadReason::other_bad) << size;
  }
  hal::FileStore nowhere(folder / "no");
  EXPECT_EQ(save_settings(nowhere, settings).problem, SaveProblem::sync);
}

// Power goes while the second set is written beside, or, on a file system that has renamed it
// before its bytes were there, afterwards.
// Of a process that was killed, perhaps another user's; a link is not followed.
TEST(FileStore, WhatWasLeftBesideIsInNobodysWay) {
  const TemporaryFolder folder;
  Settings<double> settings = default_settings<double>();
  settings.wire = files::load_wire(std::string(files::default_wire)).wire;
  const std::string other = folder.write("other", "kept");
  std::filesystem::create_symlink("other", folder / "settings.0.part");
  hal::FileStore store(folder.path().string());
  ASSERT_TRUE(save_settings(store, settings).ok());
  EXPECT_EQ(file_text(other), "kept");
  EXPECT_FALSE(std::filesystem::is_symlink(folder / "settings.0"));
  EXPECT_FALSE(std::filesystem::exists(folder / "settings.0.part"));
}

TEST(FileStore, APowerCutAtAnyByteLeavesOneOfTheTwo) {
  const TemporaryFolder folder;
  Settings<double> old = default_settings<double>();
  old.wire = files::load_wire(std::string(files::default_wire)).wire;
  old = stored_settings<double>(old);
  Settings<double> next = old;
  next.limits.duty *= 0.5;
  next = stored_settings<double>(next);
  hal::FileStore store(folder / "");
  ASSERT_TRUE(save_settings(store, old).ok());
  ASSERT_TRUE(save_settings(store, next).ok());
  const std::string bytes = file_text(folder / "settings.0");
  const auto loaded = [&] {
    hal::FileStore after(folder / "");
    return load_settings<double>(after);
  };
  for (std::size_t n = 0; n <= bytes.size(); n += 61) {
    std::ofstream(folder / "settings.1.part", std::ios::trunc) << bytes.substr(0, n);
    ASSERT_TRUE(same_settings(loaded().settings, next)) << n;
  }
  for (std::size_t n = bytes.size(); n-- > 0;) {
    fs::resize_file(folder / "settings.0", n);
    const Loaded<double> then = loaded();
    ASSERT_EQ(then.slot, 1U) << n;
    ASSERT_TRUE(same_settings(then.settings, old)) << n;
  }
  hal::FileStore after(folder / "");
  ASSERT_TRUE(save_settings(after, next).ok()) << "what was left beside is in nobody's way";
  EXPECT_TRUE(same_settings(loaded().settings, next));
}

}  // namespace
}  // namespace smaservo::test::devices_test

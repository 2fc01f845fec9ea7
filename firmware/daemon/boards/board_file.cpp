#include "firmware/daemon/boards/board_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>

#include "firmware/parameters/parameters.hpp"
#include "model/files/toml/toml_table.hpp"
#include "model/units.hpp"

namespace smaservo::daemon {
namespace {

constexpr std::array<std::string_view, 2> front_end_names{"ads131m04", "iio"};
constexpr std::array<std::string_view, 3> drive_names{"iio-dac", "spi-dac", "pwm"};
constexpr std::array<std::string_view, 3> reading_names{"current", "voltage", "load"};

std::string text_or(files::TomlTable& table, std::string_view key, const std::string& otherwise) {
  return table.has(key) ? table.text(key) : otherwise;
}

template <class T = unsigned>
T whole(files::TomlTable& table, std::string_view key, double low, double high, double otherwise) {
  const double value = table.number(key, low, high, otherwise);
  if (value != std::floor(value)) {
    table.fail(key, "must be a whole number");
  }
  return static_cast<T>(value);
}

/// The n in 0..`max` for which base << n equals `value`; any other value is refused.
unsigned exponent(const files::TomlTable& table, std::string_view key, double value, unsigned base,
                  unsigned max) {
  for (unsigned n = 0; n <= max; ++n) {
    if (value == static_cast<double>(base << n)) {
      return n;
    }
  }
  table.fail(key, "must be " + std::to_string(base) + " times a power of two, up to " +
                      std::to_string(base << max));
}

hal::SpiSettings read_spi(files::TomlTable& table, unsigned mode) {
  return {table.text("spi"), mode, whole(table, "clock_Hz", 1e4, 5e7, 8e6)};
}

Ads131m04FrontEnd read_ads(files::TomlTable& table) {
  Ads131m04FrontEnd front{read_spi(table, 1), {}};
  front.settings.osr_exponent =
      exponent(table, "oversampling", table.number("oversampling", 128, 16384, 1024), 128, 7);
  if (table.has("gains")) {
    const std::vector<double> gains = table.numbers("gains", 1, 128);
    if (gains.size() != hal::ads131m04::channels) {
      table.fail("gains", "must be four numbers, one for each channel");
    }
    std::ranges::transform(gains, front.settings.gain_exponents.begin(),
                           [&](double gain) { return exponent(table, "gains", gain, 1, 7); });
  }
  return front;
}

hal::IioSettings read_iio(files::TomlTable& table) {
  hal::IioSettings iio;
  iio.device = table.text("device");
  iio.trigger = text_or(table, "trigger", "");
  iio.hrtimer_Hz = table.number("hrtimer_Hz", 1, 1e5, 0);
  if (iio.hrtimer_Hz > 0 && iio.trigger.empty()) {
    table.fail("hrtimer_Hz", "needs the key trigger as well: the name that this timer gets");
  }
  iio.buffer_length = whole(table, "buffer_length", 2, 4096, 16);
  iio.longest_wait_ns = std::llround(1e3 * table.number("longest_wait_us", 0, 2e4, 500));
  return iio;
}

/// Volts at the pins per code of the converter.
double volt_per_code(const Ads131m04FrontEnd& front, std::size_t place) {
  const unsigned gain = 1U << front.settings.gain_exponents.at(place);
  return hal::ads131m04::reference_V / gain / 0x1p23;
}

// The place of a channel in a front end's frame, and the scale of its codes.
hal::Channel place_of(files::TomlTable& table, const Ads131m04FrontEnd& ads) {
  const auto place =
      static_cast<std::size_t>(table.number("channel", 0, hal::ads131m04::channels - 1));
  return {.place = place, .scale = table.number("per_volt", -1e6, 1e6) * volt_per_code(ads, place)};
}
hal::Channel place_of(files::TomlTable& table, hal::IioSettings& iio) {
  iio.channels.push_back(table.text("channel"));
  return {.place = iio.channels.size() - 1, .scale = table.number("per_code", -1e6, 1e6)};
}

hal::Channel read_channel(files::TomlTable table, BoardFile& file) {
  hal::Channel channel =
      std::visit([&](auto& front) { return place_of(table, front); }, file.front_end);
  if (channel.scale == 0) {
    table.fail(table.has("per_code") ? "per_code" : "per_volt", "must not be zero");
  }
  channel.zero_code = table.number("zero_code", -1e10, 1e10, 0);
  table.finish();
  return channel;
}

void read_front_end(files::TomlTable table, BoardFile& file) {
  if (table.choice("type", front_end_names) == 0) {
    file.front_end = read_ads(table);
  } else {
    file.front_end = read_iio(table);
  }
  file.calibration.current = read_channel(table.table(reading_names[0]), file);
  file.calibration.voltage = read_channel(table.table(reading_names[1]), file);
  file.calibration.has_load = table.has(reading_names[2]);
  if (file.calibration.has_load) {
    file.calibration.load = read_channel(table.table(reading_names[2]), file);
  }
  table.finish();
}

hal::DacScale read_scale(files::TomlTable& table) {
  hal::DacScale scale{};
  scale.voltage = table.has("codes_per_volt");
  scale.codes_per_unit =
      table.number(scale.voltage ? "codes_per_volt" : "codes_per_ampere", 1e-3, 1e9);
  scale.max_code = table.number("max_code", 1, 16777215, 65535);
  scale.zero_code = table.number("zero_code", 0, scale.max_code, 0);
  return scale;
}

/// A missing key means no ceiling.
canopen::Ceilings read_ceilings(files::TomlTable table) {
  const auto ceiling = [&](std::string_view key, double low, double high, double factor,
                           double offset) {
    return table.has(key) ? static_cast<float>(factor * table.number(key, low, high) + offset)
                          : canopen::Ceilings::none;
  };
  const auto current = [&](std::string_view key) { return ceiling(key, 1, 1e5, 1e-3, 0); };
  const auto temperature = [&](std::string_view key) {
    return ceiling(key, 0, 400, 1, zero_degC_K);
  };
  const auto stress = [&](std::string_view key) { return ceiling(key, 1, 1e4, 1e6, 0); };
  const canopen::Ceilings ceilings{.current_A = current("current_mA"),
                                   .power_W = ceiling("power_W", 1e-3, 1e4, 1, 0),
                                   .temperature_K = temperature("temperature_degC"),
                                   .stress_Pa = stress("stress_MPa"),
                                   .trip_current_A = current("trip_current_mA"),
                                   .trip_temperature_K = temperature("trip_temperature_degC"),
                                   .trip_stress_Pa = stress("trip_stress_MPa")};
  table.finish();
  return ceilings;
}

void read_drive(files::TomlTable table, BoardFile& file) {
  const auto hardware_A = static_cast<float>(1e-3 * table.number("max_mA", 1, 1e5));
  file.ceilings.current_A = std::min(file.ceilings.current_A, hardware_A);
  switch (table.choice("type", drive_names)) {
    case 0:
      file.drive = hal::IioDacSettings{
          table.text("device"), text_or(table, "channel", "out_voltage0"), read_scale(table)};
      break;
    case 1: {
      hal::SpiDacSettings dac{};
      dac.spi = read_spi(table, whole(table, "mode", 0, 3, 1));
      dac.frame_bytes = whole(table, "frame_bytes", 2, 3, 3);
      dac.command = whole<std::uint32_t>(table, "command", 0, 16777215, 0);
      dac.shift = whole(table, "shift", 0, 16, 0);
      dac.scale = read_scale(table);
      file.drive = dac;
      break;
    }
    default: {
      hal::PwmSettings pwm;
      pwm.chip = text_or(table, "chip", pwm.chip);
      pwm.channel = whole(table, "channel", 0, 63, 0);
      pwm.period_ns = std::llround(1e9 / table.number("frequency_Hz", 10, 1e6, 20e3));
      pwm.supply_V = table.number("supply_V", 0.5, 1000);
      pwm.max_duty = table.number("max_duty", 0.001, 1, 0.95);
      file.drive = pwm;
    }
  }
  table.finish();
}

hal::LineSettings read_line(files::TomlTable& lines, std::string_view key) {
  if (!lines.has(key)) {
    return {};
  }
  files::TomlTable table = lines.table(key);
  const hal::LineSettings line{table.text("line"), table.flag("active_low", false)};
  table.finish();
  return line;
}

hal::SlowSensor read_slow(files::TomlTable& slow, std::string_view key, bool temperature) {
  if (!slow.has(key)) {
    return {};
  }
  files::TomlTable table = slow.table(key);
  hal::SlowSensor sensor{table.text("file"), table.number("scale", -1e6, 1e6),
                         table.number("offset", -1e9, 1e9, 0)};
  // The kernel gives temperatures in degrees Celsius.
  if (temperature && sensor.scale != 0) {
    sensor.offset += zero_degC_K / sensor.scale;
  }
  table.finish();
  return sensor;
}

BusSettings read_bus(files::TomlTable table) {
  constexpr double max_key = 4294967295;
  const BusSettings bus{table.text("interface"),
                        whole(table, "node_id", 0, 127, 0),
                        1e-3 * table.number("lost_after_ms", 0, 6e4, 0),
                        {.tune = whole(table, "tune_key", 0, max_key, 0),
                         .set_up = whole(table, "set_up_key", 0, max_key, 0)},
                        table.flag("unattended", false)};
  table.finish();
  return bus;
}

// Opens the device that the settings name. Each kind of settings has its own function, so that a
// new kind does not compile without one.
std::unique_ptr<hal::Digitizer> opened(const Ads131m04FrontEnd& ads, const hal::LinuxRoots& roots) {
  return std::make_unique<hal::Ads131m04Digitizer>(std::make_unique<hal::SpiDevice>(roots, ads.spi),
                                                   roots.dev + "/" + ads.spi.device, ads.settings);
}
std::unique_ptr<hal::Digitizer> opened(const hal::IioSettings& iio, const hal::LinuxRoots& roots) {
  return std::make_unique<hal::IioDigitizer>(roots, iio);
}
std::unique_ptr<hal::OutputStage> opened(const hal::IioDacSettings& dac,
                                         const hal::LinuxRoots& roots) {
  return std::make_unique<hal::IioDac>(roots, dac);
}
std::unique_ptr<hal::OutputStage> opened(const hal::SpiDacSettings& dac,
                                         const hal::LinuxRoots& roots) {
  return std::make_unique<hal::SpiDac>(roots, dac);
}
std::unique_ptr<hal::OutputStage> opened(const hal::PwmSettings& pwm,
                                         const hal::LinuxRoots& roots) {
  return std::make_unique<hal::PwmDrive>(roots, pwm);
}

// Whether an output stage takes a voltage; otherwise it takes a current.
bool takes_voltage(const hal::IioDacSettings& dac) {
  return dac.scale.voltage;
}
bool takes_voltage(const hal::SpiDacSettings& dac) {
  return dac.scale.voltage;
}
bool takes_voltage(const hal::PwmSettings& /*pwm*/) {
  return true;
}

}  // namespace

BoardFile load_board_file(const std::string& path) {
  const files::TomlFile toml(path);
  files::TomlTable root = toml.root();
  BoardFile file{};
  file.name = root.text("name");
  const std::string device = text_or(root, "settings", "");
  file.device = device.empty() ? "" : toml.beside(device);
  file.folder = text_or(root, "folder", default_folder);
  files::TomlTable loop = root.table_or_empty("loop");
  file.thread.priority = whole<int>(loop, "priority", 1, 98, 80);
  file.thread.processor = whole<int>(loop, "processor", 0, 1023, -1);
  loop.finish();
  read_front_end(root.table("front_end"), file);
  file.ceilings = read_ceilings(root.table_or_empty("ceilings"));
  read_drive(root.table("drive"), file);
  files::TomlTable lines = root.table_or_empty("lines");
  file.lines = {read_line(lines, "enable"), read_line(lines, "kick"),
                read_line(lines, "emergency_stop"), read_line(lines, "driver_fault")};
  lines.finish();
  files::TomlTable slow = root.table_or_empty("sensors");
  file.slow = {read_slow(slow, "supply", false), read_slow(slow, "ambient", true),
               read_slow(slow, "driver", true)};
  slow.finish();
  if (root.has("bus")) {
    file.bus = read_bus(root.table("bus"));
  }
  root.finish();
  file.text = toml.text();
  return file;
}

std::unique_ptr<hal::Digitizer> open_front_end(const BoardFile& file,
                                               const hal::LinuxRoots& roots) {
  return std::visit([&](const auto& front) { return opened(front, roots); }, file.front_end);
}

std::unique_ptr<hal::OutputStage> open_drive(const BoardFile& file, const hal::LinuxRoots& roots) {
  return std::visit([&](const auto& drive) { return opened(drive, roots); }, file.drive);
}

bool drives(const BoardFile& file, const hal::LinuxRoots& roots, const std::string& device) {
  const auto* const adc = std::get_if<Ads131m04FrontEnd>(&file.front_end);
  const auto* const iio = std::get_if<hal::IioSettings>(&file.front_end);
  const auto* const iio_dac = std::get_if<hal::IioDacSettings>(&file.drive);
  const auto* const spi_dac = std::get_if<hal::SpiDacSettings>(&file.drive);
  const auto* const pwm = std::get_if<hal::PwmSettings>(&file.drive);
  if (device.empty() || device.find('/') != std::string::npos) {
    return false;
  }
  if (device.starts_with("gpiochip")) {
    const hal::LinesSettings& lines = file.lines;
    return std::ranges::any_of(
        std::array{&lines.enable, &lines.kick, &lines.emergency_stop, &lines.driver_fault},
        [&](const hal::LineSettings* line) {
          return !line->name.empty() && hal::has_line(roots, device, line->name);
        });
  }
  // IIO numbers its devices and triggers, but the board file names them.
  std::string name;
  if (const std::string path = roots.sys + "/bus/iio/devices/" + device + "/name";
      hal::exists(path)) {
    name = hal::read_text(path);
  }
  return (adc != nullptr && device == adc->spi.device) ||
         (spi_dac != nullptr && device == spi_dac->spi.device) ||
         (pwm != nullptr && device == pwm->chip) ||
         (!name.empty() && ((iio != nullptr && (name == iio->device || name == iio->trigger)) ||
                            (iio_dac != nullptr && name == iio_dac->device)));
}

std::string period_problem(const Settings<double>& settings) {
  const double period_s = settings.timing.period_s;
  // Stored settings are floats: rounding must not turn an allowed period into a forbidden one.
  constexpr double slack = 1e-6;
  const bool possible =
      shortest_period_s * (1 - slack) <= period_s && period_s <= longest_period_s * (1 + slack);
  return possible ? ""
                  : fmt::format("timing.period_ms = {:.6g}: must be between {} and {} on a board",
                                1e3 * period_s, 1e3 * shortest_period_s, 1e3 * longest_period_s);
}

std::string board_problem(const BoardFile& file, const Settings<double>& settings) {
  for (const Parameter<double>& row : parameters<double>) {
    const float ceiling = canopen::ceiling_of(file.ceilings, row.key);
    if (row.type == ValueType::real && ceiling < row.get(settings).real()) {
      return fmt::format("{} = {}: must not be above the board's ceiling, {}", row.path.text(),
                         row.get(settings).real(), ceiling);
    }
  }
  const bool voltage = settings.drive.kind == DriveKind::voltage;
  const bool drive_takes_voltage =
      std::visit([](const auto& drive) { return takes_voltage(drive); }, file.drive);
  if (voltage != drive_takes_voltage) {
    return fmt::format("drive.kind = {}: must be {}, which the board's drive takes",
                       voltage ? "voltage" : "current", voltage ? "current" : "voltage");
  }
  if (settings.measurement.has_load_cell && !file.calibration.has_load) {
    return "measurement.has_load_cell = true: must be false, the board file has no front_end.load";
  }
  return "";
}

}  // namespace smaservo::daemon

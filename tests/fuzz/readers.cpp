#include "readers.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/bench/scenario/scenario.hpp"
#include "firmware/daemon/boards/board_file.hpp"
#include "firmware/daemon/process/last_run.hpp"
#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"
#include "hal/linux/can/can_datagram.hpp"
#include "hal/recording/foreign_table.hpp"
#include "hal/replay/trace.hpp"
#include "host-sim/can/bus/network.hpp"
#include "host-sim/can/bus/recording.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/can/status.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/papers/actuators/actuator_file.hpp"
#include "tests/firmware/parameters/store/memory_storage.hpp"
#include "tests/hal/recording/mcap/files.hpp"
#include "tests/places.hpp"

namespace smaservo::fuzz {
namespace {

void demand(bool holds) {
  if (!holds) {
    std::abort();
  }
}

std::string_view text_of(Input input) {
  // NOLINTNEXTLINE(*-reinterpret-cast): the same bytes as characters
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

/// A file in memory, if the machine has a folder there, for the readers that take a path. Beside it
/// stand the files that shipped ones name.
class InputFile {
 public:
  explicit InputFile(const char* name) {
    const std::filesystem::path memory = "/dev/shm";
    std::string folder =
        ((std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path()) /
         "smaservo-fuzz-XXXXXX")
            .string();
    demand(mkdtemp(folder.data()) != nullptr);
    folder_ = folder;
    const std::filesystem::path source = test::source_folder();
    std::filesystem::create_directory_symlink(source / "host-sim/scenarios/devices",
                                              folder_ / "devices");
    path_ = (folder_ / name).string();
  }
  ~InputFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& with(Input input) const {
    std::ofstream(path_, std::ios::binary) << text_of(input);
    return path_;
  }

 private:
  std::filesystem::path folder_;
  std::string path_;
};

/// Runs a reader, which may refuse its input; false: it has.
template <class Read>
bool accepted(const Read& read) {
  try {
    read();
    return true;
  } catch (const files::UserError&) {
    return false;
  } catch (const hal::TraceError&) {
    return false;
  }
}

const Settings<double>& good_settings() {
  static const Settings<double> settings =
      text::settings_for(files::load_wire(std::string(files::default_wire)).wire);
  return settings;
}

/// A bus on which only what the input says is heard.
class AnsweringBus : public can::Bus {
 public:
  explicit AnsweringBus(Input input) : left_(input) {}
  void send(const hal::CanFrame& /*frame*/) override { now_us_ += 1; }
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
    if (until_us <= now_us_ || left_.size() < 9) {
      now_us_ = std::max(now_us_, until_us);
      return false;
    }
    constexpr std::array<std::uint32_t, 8> ids{0x581, 0x581, 0x581, 0x701, 0x7E4, 0x81, 0x80, 0};
    frame = {.id = ids.at(left_[0] % ids.size()), .length = 8};
    if (frame.id == 0x701 || frame.id == 0) {
      frame.length = frame.id == 0 ? 2 : 1;
    }
    std::copy_n(left_.begin() + 1, 8, frame.data.begin());
    left_ = left_.subspan(9);
    now_us_ += 1;
    return true;
  }
  std::int64_t now_us() const override { return now_us_; }
  std::string name() const override { return "fuzz"; }

 private:
  Input left_;
  std::int64_t now_us_ = 0;
};

/// Makes the checksum behind a slot's entries that of what stands before it.
void sign(std::vector<std::byte>& slot) {
  const image::Header header = image::take_header(std::span(slot).first<image::header_size>());
  const std::size_t end = image::header_size + image::entry_size * header.entries;
  if (end + image::crc_size > slot.size()) {
    return;
  }
  Crc32 crc;
  crc.add(std::span(slot).first(end));
  for (std::size_t i = 0; i < image::crc_size; ++i) {
    slot[end + i] = static_cast<std::byte>(crc.value() >> (8 * i) & 0xFFU);
  }
}

}  // namespace

void wire(Input input) {
  files::WireDescription first;
  if (!accepted([&] { first = files::parse_wire(text_of(input), "fuzz.toml"); })) {
    return;
  }
  const std::string written = files::to_toml(first);
  demand(files::to_toml(files::parse_wire(written, "written.toml")) == written);
}

void settings(Input input) {
  Settings<double> changed = good_settings();
  text::apply_changes(text_of(input), changed);
  Settings<double> first = changed;
  if (!accepted([&] { first = text::parse_settings_file(text_of(input), "fuzz.toml"); })) {
    return;
  }
  demand(check(first).ok());
  const std::string written = text::to_toml(first);
  demand(text::to_toml(text::parse_settings_file(written, "written.toml")) == written);
}

void scenario(Input input) {
  static const InputFile file("scenario.toml");
  const std::string& path = file.with(input);
  accepted([&] { bench::load_closed_loop(path); });
  accepted([&] { bench::load_scenario(path); });
}

void board(Input input) {
  static const InputFile file("board.toml");
  accepted([&] { daemon::load_board_file(file.with(input)); });
}

void actuator(Input input) {
  accepted([&] { papers::parse_actuator(text_of(input), "fuzz.toml"); });
}

void trace(Input input) {
  if (hal::ForeignTable::begins(text_of(input))) {
    return;  // another program reads these; ForeignTable's tests damage them
  }
  static const InputFile file("trace.csv");
  const std::string& path = file.with(input);
  const hal::TraceOptions all[] = {
      {},
      {.lenient = true, .period_s = 0.01, .renames = {}, .resistance_and_power = true},
      {.lenient = true, .period_s = 0, .renames = {"time_s=t*1e-3"}, .device = true}};
  for (const hal::TraceOptions& options : all) {
    accepted([&] {
      hal::TraceReader reader(path, options);
      for (hal::TraceRow row; reader.next(row);) {
      }
      demand(reader.rows() + reader.skipped() <= input.size());
    });
  }
}

void mcap(Input input) {
  std::string bytes(text_of(input));
  if (!input.empty() && input[0] % 2 == 1) {
    hal::mcap::Writer writer("fuzz", false);
    std::string_view lines = text_of(input.subspan(1));
    bool has_schema = false;
    while (!lines.empty()) {
      const std::string_view line = lines.substr(0, lines.find('\n'));
      lines.remove_prefix(std::min(lines.size(), line.size() + 1));
      if (has_schema) {
        writer.message(0, line);
      } else {
        writer.stream({"fuzz", std::string(line), "/trace"});
      }
      has_schema = true;
    }
    writer.finish();
    bytes = writer.take();
  }
  test::Read first = test::read_mcap(bytes);
  if (!first.problem.empty() || first.csv.find('\r') != std::string::npos ||
      first.csv.starts_with("\xEF\xBB\xBF")) {
    return;
  }
  std::string written;
  if (accepted([&] { written = test::to_mcap(first.csv); })) {
    const test::Read again = test::read_mcap(written);
    demand(again.problem.empty() && again.cut_off.empty());
    // Rows without a value are empty lines, which a trace does not have; names lose their spaces.
    demand(std::ranges::count(again.csv, '\n') <= std::ranges::count(first.csv, '\n'));
    demand(test::read_mcap(test::to_mcap(again.csv)) == again);
  }
}

void recording(Input input) {
  static const InputFile file("step.csv");
  can::Recording first;
  if (!accepted([&] { first = can::load_recording(file.with(input)); })) {
    return;
  }
  const std::string written = can::to_csv(first);
  // The times of a period that nine digits do not tell apart are refused.
  if (first.period_s > 1e-6 && first.period_s < 1e6) {
    const can::Recording again = can::load_recording(file.with(
        {reinterpret_cast<const std::uint8_t*>(written.data()),  // NOLINT(*-reinterpret-cast)
         written.size()}));
    demand(again.signals == first.signals && again.rows.size() == first.rows.size());
  }
}

void mark(Input input) {
  static const InputFile file("run");
  const std::filesystem::path folder = std::filesystem::path(file.with(input)).parent_path();
  std::ofstream(folder / "service-result", std::ios::binary) << text_of(input);
  {
    const daemon::RunMark run(folder, "boot");
    const std::string said = daemon::describe(run.last());
    demand(std::ranges::none_of(said, [](unsigned char c) { return c < ' ' || c == 0x7F; }));
  }
  std::filesystem::remove(folder / "history");
}

void store(Input input) {
  static const MemoryStorage good = [] {
    MemoryStorage storage;
    Settings<double> settings = good_settings();
    demand(save_settings(storage, settings).ok());
    settings.limits.current_A *= 0.5;
    demand(save_settings(storage, settings).ok());
    return storage;
  }();
  MemoryStorage storage = good;
  std::array<bool, slot_count> signs{};
  for (; input.size() >= 4; input = input.subspan(4)) {
    const unsigned slot = input[0] & 1U;
    signs.at(slot) = (input[0] & 2U) != 0;
    storage.slots[slot][(input[1] | static_cast<std::size_t>(input[2]) << 8U) %
                        MemoryStorage::slot_size] = static_cast<std::byte>(input[3]);
  }
  for (unsigned slot = 0; slot < slot_count; ++slot) {
    if (signs.at(slot)) {
      sign(storage.slots[slot]);
    }
  }
  const Loaded<double> loaded = load_settings<double>(storage);
  demand(loaded.reason == LoadReason::none || check(loaded.settings).ok());
  for (unsigned slot = 0; slot < slot_count; ++slot) {
    salvage<double>(storage, slot, [](const auto&, const auto&) {});
  }
  demand(save_settings(storage, good_settings()).ok());
  const Loaded<double> back = load_settings<double>(storage);
  demand(back.reason != LoadReason::none &&
         same_settings(back.settings, stored_settings<double>(good_settings())));
}

void client(Input input) {
  const std::array<std::uint8_t, 20> value{1, 2, 3};
  constexpr Key key{0x2220, 2};
  const auto ask = [&](const auto& what) {
    AnsweringBus bus(input);
    can::Remote remote(can::SdoClient(bus, 1));
    accepted([&] { what(remote); });
  };
  ask([&](can::Remote& r) { r.client().upload(key); });
  ask([&](can::Remote& r) { r.client().upload_block(key); });
  ask([&](can::Remote& r) { r.client().download(key, value); });
  ask([&](can::Remote& r) { r.client().download_block(key, value); });
  ask([](can::Remote& r) { can::changes_text(r); });
  ask([](can::Remote& r) { can::faults_text(r); });
  ask([](can::Remote& r) { can::info_text(r, Units::bench); });
  ask([](can::Remote& r) { r.enable(); });
  ask([](can::Remote& r) { can::scan(r.bus(), 1000); });
  AnsweringBus bus(input);
  for (hal::CanFrame frame; bus.receive(frame, bus.now_us() + 1);) {
    can::frame_text(frame);
  }
}

void datagram(Input input) {
  std::vector<std::uint8_t> bytes(input.begin(), input.end());
  if (!input.empty() && input[0] % 2 == 1) {
    bytes = hal::to_datagram({.id = 0x601, .length = 8, .data = {0x23, 0x17, 0x10}}, 1e9);
    for (input = input.subspan(1); input.size() >= 2; input = input.subspan(2)) {
      bytes[input[0] % bytes.size()] = input[1];
    }
  }
  const std::optional<hal::CanFrame> frame = hal::from_datagram(bytes);
  demand(!frame || hal::from_datagram(hal::to_datagram(*frame, 0)) == frame);
}

}  // namespace smaservo::fuzz

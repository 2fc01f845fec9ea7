#include "hal/linux/devices/iio.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <poll.h>

#include "hal/linux/system/clock.hpp"

namespace smaservo::hal {
namespace {

constexpr std::size_t scans_at_once = 64;
constexpr const char* timestamp = "in_timestamp";

ScanElement element_of(const std::string& folder, const std::string& channel) {
  const std::string base = folder + "/scan_elements/" + channel;
  if (!exists(base + "_type")) {
    throw DeviceError(fmt::format("{}: has no scan element {}", folder, channel));
  }
  const std::string text = read_text(base + "_type");
  const auto type = parse_scan_type(text);
  if (!type) {
    throw DeviceError(
        fmt::format("{}_type: '{}' is no scan type of IIO, such as le:s24/32>>8", base, text));
  }
  return {channel, static_cast<unsigned>(read_number(base + "_index")), *type};
}

/// An attribute of the channel (in_voltage0_scale), or otherwise that of all channels of its kind
/// (in_voltage_scale).
double attribute(const std::string& folder, const std::string& channel, const char* what,
                 double otherwise) {
  const std::string own = folder + "/" + channel + "_" + what;
  std::string kind = channel;
  while (!kind.empty() && kind.back() >= '0' && kind.back() <= '9') {
    kind.pop_back();
  }
  const std::string shared = folder + "/" + kind + "_" + what;
  return exists(own) ? read_number(own) : exists(shared) ? read_number(shared) : otherwise;
}

void make_trigger(const LinuxRoots& roots, const IioSettings& settings) {
  if (settings.hrtimer_Hz <= 0) {
    return;
  }
  const std::string folder = roots.config + "/iio/triggers/hrtimer/" + settings.trigger;
  std::error_code error;
  std::filesystem::create_directory(folder, error);
  if (error) {
    throw DeviceError(
        fmt::format("{}: {}; is the module iio-trig-hrtimer loaded?", folder, error.message()));
  }
  const std::string trigger =
      find_by_name(roots.sys + "/bus/iio/devices", "trigger", settings.trigger);
  wait_until_writable(trigger + "/sampling_frequency");
  write_text(trigger + "/sampling_frequency", fmt::format("{}", settings.hrtimer_Hz));
}

}  // namespace

IioDigitizer::IioDigitizer(const LinuxRoots& roots, const IioSettings& settings)
    : folder_(find_by_name(roots.sys + "/bus/iio/devices", "iio:device", settings.device)),
      channels_(settings.channels.size()),
      longest_wait_ns_(settings.longest_wait_ns) {
  make_trigger(roots, settings);
  std::vector<ScanElement> elements;
  for (const std::string& channel : settings.channels) {
    elements.push_back(element_of(folder_, channel));
    meanings_.push_back(
        {attribute(folder_, channel, "scale", 1), attribute(folder_, channel, "offset", 0)});
  }
  const std::string clock = folder_ + "/current_timestamp_clock";
  has_time_ = exists(folder_ + "/scan_elements/in_timestamp_en") && exists(clock);
  if (has_time_) {
    elements.push_back(element_of(folder_, timestamp));
  }
  layout_ = lay_out(elements);
  scans_.resize(layout_.size * scans_at_once);
  enable(settings);
  const std::string node = roots.dev + "/" + std::filesystem::path(folder_).filename().string();
  file_ = open_file(node, O_RDONLY | O_NONBLOCK);
}

void IioDigitizer::enable(const IioSettings& settings) {
  write_text(folder_ + "/buffer/enable", "0");
  if (has_time_) {
    write_text(folder_ + "/current_timestamp_clock", "monotonic");
  }
  // Disables the elements that another program has left enabled, since their samples would stand
  // between ours.
  for (const auto& entry : std::filesystem::directory_iterator(folder_ + "/scan_elements")) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with("_en")) {
      const std::string channel = name.substr(0, name.size() - 3);
      const bool wanted = (has_time_ && channel == timestamp) ||
                          std::ranges::find(settings.channels, channel) != settings.channels.end();
      write_text(entry.path(), wanted ? "1" : "0");
    }
  }
  if (!settings.trigger.empty()) {
    write_text(folder_ + "/trigger/current_trigger", settings.trigger);
  }
  write_text(folder_ + "/buffer/length", std::to_string(settings.buffer_length));
  write_text(folder_ + "/buffer/enable", "1");
}

IioDigitizer::~IioDigitizer() {
  try {
    write_text(folder_ + "/buffer/enable", "0");
  } catch (const DeviceError&) {
    return;  // the device is gone
  }
}

bool IioDigitizer::wait() const {
  pollfd file{file_.number(), POLLIN, 0};
  const timespec time{0, static_cast<long>(longest_wait_ns_)};
  return ppoll(&file, 1, &time, nullptr) > 0 && (file.revents & POLLIN) != 0;
}

bool IioDigitizer::read(RawFrame& raw) {
  std::size_t size = 0;
  bool waited = false;
  for (;;) {
    const ssize_t n = ::read(file_.number(), scans_.data(), scans_.size());
    if (n > 0) {
      size = static_cast<std::size_t>(n);
      sequence_ += static_cast<std::uint32_t>(size / layout_.size);
      if (size == scans_.size()) {
        continue;  // the buffer may have newer scans
      }
    }
    // EAGAIN means that the buffer is empty.
    if (size != 0 || waited || (n < 0 && errno != EAGAIN) || !wait()) {
      break;
    }
    waited = true;
  }
  if (size < layout_.size) {
    return false;
  }
  const auto scan = std::span<const std::byte>(scans_).subspan(
      (size / layout_.size - 1) * layout_.size, layout_.size);
  for (std::size_t i = 0; i < channels_; ++i) {
    raw.codes[i] = sample_of(layout_.elements[i], scan);
  }
  raw.time_ns = has_time_ ? sample_of(layout_.elements[channels_], scan) : monotonic_ns();
  raw.sequence = sequence_;
  return true;
}

}  // namespace smaservo::hal

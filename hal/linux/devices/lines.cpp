#include "hal/linux/devices/lines.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <gpiod.h>
#include <linux/gpio.h>
#include <vector>

namespace smaservo::hal {
namespace {

template <auto free_it>
struct Free {
  template <class T>
  void operator()(T* object) const {
    free_it(object);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using OneSettings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using Request = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;

struct Line {
  Request request;
  unsigned offset = 0;

  bool there() const { return request != nullptr; }
  bool set(bool on) const {
    return !there() || gpiod_line_request_set_value(
                           request.get(), offset,
                           on ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE) == 0;
  }
  /// A line that cannot be read counts as active.
  bool active() const {
    return there() &&
           gpiod_line_request_get_value(request.get(), offset) != GPIOD_LINE_VALUE_INACTIVE;
  }
};

Line request_at(gpiod_chip* chip, unsigned offset, const LineSettings& wanted, bool output) {
  const OneSettings settings(gpiod_line_settings_new());
  const LineConfig lines(gpiod_line_config_new());
  const RequestConfig config(gpiod_request_config_new());
  gpiod_line_settings_set_direction(
      settings.get(), output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT);
  gpiod_line_settings_set_active_low(settings.get(), wanted.active_low);
  gpiod_line_settings_set_output_value(settings.get(), GPIOD_LINE_VALUE_INACTIVE);
  gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings.get());
  gpiod_request_config_set_consumer(config.get(), "smaservod");
  Request request(gpiod_chip_request_lines(chip, config.get(), lines.get()));
  if (!request) {
    throw DeviceError(fmt::format("line {}: {}{}", wanted.name, std::strerror(errno),
                                  errno == EBUSY ? ": another program has it" : ""));
  }
  return {std::move(request), offset};
}

Line open_line(const LinuxRoots& roots, const LineSettings& wanted, bool output) {
  if (wanted.name.empty()) {
    return {};
  }
  int chips = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(roots.dev, error)) {
    if (!entry.path().filename().string().starts_with("gpiochip")) {
      continue;
    }
    const Chip chip(gpiod_chip_open(entry.path().c_str()));
    if (!chip) {
      continue;
    }
    ++chips;
    const int offset = gpiod_chip_get_line_offset_from_name(chip.get(), wanted.name.c_str());
    if (offset >= 0) {
      return request_at(chip.get(), static_cast<unsigned>(offset), wanted, output);
    }
  }
  throw DeviceError(
      fmt::format("line {}: no such line on the {} chips {}/gpiochip* that can be "
                  "opened",
                  wanted.name, chips, roots.dev));
}

class GpioLines : public Lines {
 public:
  GpioLines(const LinuxRoots& roots, const LinesSettings& settings)
      : enable_(open_line(roots, settings.enable, true)),
        kick_(open_line(roots, settings.kick, true)),
        stop_(open_line(roots, settings.emergency_stop, false)),
        fault_(open_line(roots, settings.driver_fault, false)) {}

  bool emergency_stop() override { return stop_.active(); }
  bool driver_fault() override { return fault_.active(); }
  bool enable(bool on) override { return enable_.set(on); }
  bool kick() override {
    const bool up = kick_.set(true);
    return kick_.set(false) && up;
  }
  std::vector<OffAction> off_actions() override {
    std::vector<OffAction> actions;
    for (const Line* line : {&enable_, &kick_}) {
      if (line->there()) {
        actions.push_back({gpiod_line_request_get_fd(line->request.get()),
                           GPIO_V2_LINE_SET_VALUES_IOCTL, &off_, 0});
      }
    }
    return actions;
  }

 private:
  Line enable_, kick_, stop_, fault_;
  gpio_v2_line_values off_{.bits = 0, .mask = 1};
};

}  // namespace

bool has_line(const LinuxRoots& roots, const std::string& chip, const std::string& name) {
  const Chip opened(gpiod_chip_open((roots.dev + "/" + chip).c_str()));
  return opened && gpiod_chip_get_line_offset_from_name(opened.get(), name.c_str()) >= 0;
}

std::unique_ptr<Lines> open_lines(const LinuxRoots& roots, const LinesSettings& settings) {
  return std::make_unique<GpioLines>(roots, settings);
}

}  // namespace smaservo::hal

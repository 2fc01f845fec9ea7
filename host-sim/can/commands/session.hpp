#pragma once
// What the commands of `host-sim can` share: the options before a command, the connection that they
// name, and how a command prints. Only *_command.cpp include it (options.hpp says why).

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host-sim/can/bus/port_bus.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/options.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

struct Common {
  std::string can;
  unsigned node = 1;
  std::optional<std::uint32_t> key;
  double timeout_s = 0.5;
  Units units = Units::bench;
  bool quiet = false;
};

/// The bus and the node that a run uses.
class Session {
 public:
  explicit Session(const Common& common) : bus_(common.can), remote_({bus_, common.node}) {
    remote_.client().set_timeout(static_cast<std::int64_t>(common.timeout_s * 1e6));
    if (common.key) {
      remote_.set("access.key", std::to_string(*common.key));
    }
  }

  can::PortBus& bus() { return bus_; }
  Remote& remote() { return remote_; }

 private:
  can::PortBus bus_;
  Remote remote_;
};

/// Prints to the standard output, at once.
void print(const std::string& text);

/// Says on the standard error output what a command has made so. The command has worked by then, so
/// a failure to read for this does not make it fail.
void say(const Common& common, const std::function<std::string()>& text);

/// Adds a command that `run` carries out.
CLI::App* add(CLI::App& can, const char* name, const char* meaning,
              const std::function<void()>& run);

/// Adds a command that has no options of its own.
void add_plain(CLI::App& can, const std::shared_ptr<Common>& common, const char* name,
               const char* meaning, void (*run)(Remote&, const Common&));

/// Like CLI::Range, but refuses NaN as well.
CLI::Validator seconds_of(double low, double high);

// The groups of commands, each in a file of its name.
void add_network_commands(CLI::App& can, const std::shared_ptr<Common>& common);
void add_object_commands(CLI::App& can, const std::shared_ptr<Common>& common);
void add_watch_commands(CLI::App& can, const std::shared_ptr<Common>& common);
void add_motion_commands(CLI::App& can, const std::shared_ptr<Common>& common);

}  // namespace smaservo::can

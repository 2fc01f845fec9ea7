#pragma once
// The files that the kernel makes of its devices.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::hal {

/// A device that can not be used: names the file and says why.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An output that another process drives.
class DeviceBusy : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

/// Where they are; elsewhere in tests.
struct LinuxRoots {
  std::string sys = "/sys";
  std::string dev = "/dev";
  std::string config = "/sys/kernel/config";
  bool takes_over = false;  ///< outputs that another process drives as well
};

// All throw DeviceError.
Descriptor open_file(const std::string& path, int flags);
/// From now on until it is closed this process alone drives the output: throws DeviceBusy where
/// another one does.
void take_output(int descriptor, const std::string& path, const LinuxRoots& roots);
/// Without the line's end.
std::string read_text(const std::string& path);
double read_number(const std::string& path);
void write_text(const std::string& path, std::string_view text);
bool exists(const std::string& path);
/// udev gives a file to its user a moment after it has appeared; half a second at most.
void wait_until_writable(const std::string& path);
/// The folder in `parent` whose name begins with `prefix` and whose attribute `name` says this.
std::string find_by_name(const std::string& parent, const std::string& prefix,
                         const std::string& name);

/// A whole number that a kept descriptor is told, from its beginning; no allocation.
bool put_number(int descriptor, std::int64_t number);

}  // namespace smaservo::hal

#pragma once
// The files through which the kernel offers its devices.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/linux/system/descriptor.hpp"
#include "model/files/error.hpp"

namespace smaservo::hal {

/// A device cannot be used; the text names the file and says why.
class DeviceError : public files::Error {
 public:
  using Error::Error;
};

/// Another process is driving the output.
class DeviceBusy : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

/// The folders of the kernel's files; tests use others.
struct LinuxRoots {
  std::string sys = "/sys";
  std::string dev = "/dev";
  std::string config = "/sys/kernel/config";
  bool takes_over = false;  ///< opens outputs even if another process is driving them
};

// The functions below throw DeviceError.
Descriptor open_file(const std::string& path, int flags);
/// Locks the output for this process until the descriptor is closed; throws DeviceBusy if another
/// process is driving it.
void take_output(int descriptor, const std::string& path, const LinuxRoots& roots);
/// The text of a file without its line end.
std::string read_text(const std::string& path);
double read_number(const std::string& path);
void write_text(const std::string& path, std::string_view text);
bool exists(const std::string& path);
/// Waits until udev has made a new file writable for this user, half a second at most.
void wait_until_writable(const std::string& path);
/// The folder in `parent` whose name begins with `prefix` and whose attribute `name` has the value
/// `name`.
std::string find_by_name(const std::string& parent, const std::string& prefix,
                         const std::string& name);

/// Writes a whole number to the beginning of an open file; allocates nothing. False if that failed.
bool put_number(int descriptor, std::int64_t number);

}  // namespace smaservo::hal

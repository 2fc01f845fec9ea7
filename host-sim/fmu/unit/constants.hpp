#pragma once
// The file of an FMU's values: lines "name = number", in resources/values.txt.
//
//   kind = wire
//   token = {...}
//   interface = 16 hexadecimal digits
//   separate_r2a = 0
//   wire.length_m = 0.1

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>

namespace smaservo::fmu::unit {

/// Says what is wrong with the file.
struct ConstantsError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Constants {
  std::string kind, token;
  std::uint64_t interface = 0;
  std::map<std::string, double> numbers;

  /// The number of this name, which is taken out. Throws ConstantsError where it is missing.
  double take(const std::string& name);
  /// Throws ConstantsError if a number is left.
  void finish() const;
};

/// Reads the file in this folder. Throws ConstantsError.
Constants read_constants(const std::string& folder);

/// The folder of a URI "file:///...", with its percent escapes resolved, or of a path. Throws
/// ConstantsError.
std::string folder_of(const std::string& location);

}  // namespace smaservo::fmu::unit

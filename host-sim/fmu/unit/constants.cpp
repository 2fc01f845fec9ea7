#include "host-sim/fmu/unit/constants.hpp"

#include <cmath>
#include <fstream>
#include <locale>
#include <sstream>

namespace smaservo::fmu::unit {
namespace {

constexpr std::size_t longest_line = 1000;

/// Independent of the locale that the simulator has set.
double number_of(const std::string& text, const std::string& name) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0;
  if (!(stream >> value) || !stream.eof() || !std::isfinite(value)) {
    throw ConstantsError(name + " = " + text + " is not a number");
  }
  return value;
}

std::uint64_t hexadecimal(const std::string& text) {
  std::uint64_t value = 0;
  if (text.size() != 16) {
    throw ConstantsError("interface = " + text + " has not 16 digits");
  }
  for (const char digit : text) {
    const bool decimal = '0' <= digit && digit <= '9';
    if (!decimal && !('a' <= digit && digit <= 'f')) {
      throw ConstantsError("interface = " + text + " is not hexadecimal");
    }
    value = value * 16 + static_cast<std::uint64_t>(decimal ? digit - '0' : digit - 'a' + 10);
  }
  return value;
}

int digit_of(char letter) {
  return '0' <= letter && letter <= '9'   ? letter - '0'
         : 'a' <= letter && letter <= 'f' ? letter - 'a' + 10
         : 'A' <= letter && letter <= 'F' ? letter - 'A' + 10
                                          : -1;
}

std::string unescaped(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? digit_of(text[i + 1]) : -1;
    const int low = high < 0 ? -1 : digit_of(text[i + 2]);
    if (low < 0 || 16 * high + low == 0) {
      throw ConstantsError("the location of the resources has a wrong escape: " + text);
    }
    result += static_cast<char>(16 * high + low);
    i += 2;
  }
  return result;
}

}  // namespace

double Constants::take(const std::string& name) {
  const auto at = numbers.find(name);
  if (at == numbers.end()) {
    throw ConstantsError(name + " is missing");
  }
  const double value = at->second;
  numbers.erase(at);
  return value;
}

void Constants::finish() const {
  if (!numbers.empty()) {
    throw ConstantsError(numbers.begin()->first + " is unknown");
  }
}

Constants read_constants(const std::string& folder) {
  const std::string path = folder + "/values.txt";
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw ConstantsError(path + " cannot be read");
  }
  Constants all;
  bool has_interface = false;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (file.eof() || line.size() > longest_line) {
      throw ConstantsError(path + " is cut off or not a file of values");
    }
    const std::size_t equals = line.find(" = ");
    if (equals == std::string::npos) {
      throw ConstantsError(path + ":" + std::to_string(number) + " is not \"name = value\"");
    }
    const std::string name = line.substr(0, equals);
    const std::string value = line.substr(equals + 3);
    if (name == "kind") {
      all.kind = value;
    } else if (name == "token") {
      all.token = value;
    } else if (name == "interface") {
      all.interface = hexadecimal(value);
      has_interface = true;
    } else if (!all.numbers.emplace(name, number_of(value, name)).second) {
      throw ConstantsError(path + ":" + std::to_string(number) + ": " + name + " stands twice");
    }
  }
  if (file.bad() || all.kind.empty() || all.token.empty() || !has_interface) {
    throw ConstantsError(path + " lacks kind, token or interface");
  }
  return all;
}

std::string folder_of(const std::string& location) {
  std::string path = location;
  if (location.starts_with("file:")) {
    path = unescaped(location.substr(5));
    if (path.starts_with("//")) {
      const std::size_t end = path.find('/', 2);
      const std::string host = path.substr(2, end == std::string::npos ? end : end - 2);
      if (end == std::string::npos || (!host.empty() && host != "localhost")) {
        throw ConstantsError("the location of the resources is on another machine: " + location);
      }
      path.erase(0, end);
    }
    // Of Windows: /C:/folder.
    if (path.size() > 2 && path[2] == ':') {
      path.erase(0, 1);
    }
  } else if (location.find("://") != std::string::npos) {
    throw ConstantsError("the location of the resources is no file: " + location);
  }
  while (path.size() > 1 && (path.back() == '/' || path.back() == '\\')) {
    path.pop_back();
  }
  if (path.empty()) {
    throw ConstantsError("there is no location of the resources");
  }
  return path;
}

}  // namespace smaservo::fmu::unit

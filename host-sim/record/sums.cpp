#include "host-sim/record/sums.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <memory>
#include <openssl/evp.h>

#include "model/files/error.hpp"

namespace smaservo::record {
namespace {

constexpr std::size_t hex_digits = 64;

bool is_hex(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    return ('0' <= c && c <= '9') || ('a' <= c && c <= 'f') || ('A' <= c && c <= 'F');
  });
}

std::string lower_hex(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](char c) {
    return 'A' <= c && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return lower;
}

}  // namespace

std::string sha256_of_file(const std::string& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> hash(EVP_MD_CTX_new(),
                                                                     &EVP_MD_CTX_free);
  bool good = EVP_DigestInit_ex(hash.get(), EVP_sha256(), nullptr) == 1;
  std::vector<char> buffer(std::size_t{1} << 16U);
  while (in && in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())).gcount() > 0) {
    good &= EVP_DigestUpdate(hash.get(), buffer.data(), static_cast<std::size_t>(in.gcount())) == 1;
  }
  if (!in.eof()) {
    throw files::UserError(
        fmt::format("{}: cannot be read: {}", path, std::strerror(errno != 0 ? errno : EIO)));
  }
  std::array<unsigned char, hex_digits / 2> bytes{};
  if (!good || EVP_DigestFinal_ex(hash.get(), bytes.data(), nullptr) != 1) {
    throw files::UserError(fmt::format("{}: libcrypto has no SHA-256 here", path));
  }
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

bool stays_inside(const std::string& path) {
  const std::string framed = "/" + path + "/";
  return framed.find("//") == std::string::npos && framed.find("/../") == std::string::npos &&
         framed.find("/./") == std::string::npos && path.find('\0') == std::string::npos;
}

std::string sums_text(const std::vector<Sum>& sums) {
  std::string text;
  for (const Sum& sum : sums) {
    text += fmt::format("{}  {}\n", sum.hex, sum.path);
  }
  return text;
}

std::vector<Sum> parse_sums(std::string_view text, const std::string& origin,
                            std::vector<std::string>& faults) {
  std::vector<Sum> sums;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line.remove_suffix(line.ends_with('\r') ? 1 : 0);
    const bool is_sum = line.size() > hex_digits + 2 && is_hex(line.substr(0, hex_digits)) &&
                        line[hex_digits] == ' ' &&
                        (line[hex_digits + 1] == ' ' || line[hex_digits + 1] == '*');
    if (!is_sum) {
      faults.push_back(
          fmt::format("{}:{}: '{}': must be 64 hexadecimal digits, two blanks and the name of a "
                      "file, as sha256sum writes them",
                      origin, number, line));
      continue;
    }
    sums.push_back(
        {lower_hex(line.substr(0, hex_digits)), std::string(line.substr(hex_digits + 2))});
  }
  return sums;
}

}  // namespace smaservo::record

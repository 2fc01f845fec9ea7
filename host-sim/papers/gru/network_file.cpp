// The file of a network, which another program has written: nothing in it is taken for granted.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <set>

#include "host-sim/papers/gru/network.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/message.hpp"
#include "model/files/similar.hpp"

namespace smaservo::gru {
namespace {

using nlohmann::json;

constexpr int version = 1;
constexpr std::uint64_t largest_hidden = 256;  // a step of so many units takes 0.06 ms
constexpr std::uintmax_t largest_file = 8U << 20U;
constexpr int deepest = 4;  // levels of lists and objects
constexpr double largest_weight = 1e6;
constexpr std::size_t longest_text = 500;

/// A value as a message shows it.
std::string shown(const json& value) {
  constexpr std::size_t longest = 60;
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return files::printable(text.size() <= longest ? text : text.substr(0, longest) + "...");
}

/// An object of the file whose keys are all to be asked for.
class Object {
 public:
  /// `name` is that of its place in the file: "" or "output".
  Object(std::string path, std::string name, const json& value)
      : path_(std::move(path)), name_(std::move(name)), value_(value) {
    if (!value.is_object()) {
      throw files::ConfigError(
          fmt::format("{}: {}must be an object, {{\"key\": value, ...}}", path_,
                      (name_.empty() ? "" : name_ + " = ") + shown(value) + ": "));
    }
  }

  const json& at(const char* key) {
    if (std::ranges::find(known_, key) == known_.end()) {
      known_.emplace_back(key);
    }
    const auto found = value_.find(key);
    if (found == value_.end()) {
      fail(key, "is missing");
    }
    return *found;
  }

  Object object(const char* key) { return {path_, place(key), at(key)}; }

  /// An object in a list of `least` to `most` of them.
  Object element(const char* key, std::size_t i, std::size_t least, std::size_t most) {
    return {path_, fmt::format("{}[{}]", place(key), i), list(key, least, most)[i]};
  }

  double number(const char* key, double low, double high) {
    const json& value = at(key);
    // NaN compares false.
    const double x = value.is_number() ? value.get<double>() : std::nan("");
    if (!(low <= x && x <= high)) {
      refuse(key, value, fmt::format("must be a number from {} to {}", low, high));
    }
    return x;
  }

  std::uint64_t whole(const char* key, std::uint64_t low, std::uint64_t high) {
    const json& value = at(key);
    const std::uint64_t x = value.is_number_unsigned() ? value.get<std::uint64_t>() : 0;
    if (!value.is_number_unsigned() || x < low || x > high) {
      refuse(key, value,
             low == high ? fmt::format("must be {}", low)
                         : fmt::format("must be a whole number from {} to {}", low, high));
    }
    return x;
  }

  std::string text(const char* key) {
    const json& value = at(key);
    if (!value.is_string() || value.get_ref<const std::string&>().empty() ||
        value.get_ref<const std::string&>().size() > longest_text) {
      refuse(key, value, fmt::format("must be a text of 1 to {} bytes", longest_text));
    }
    return value.get<std::string>();
  }

  void require_text(const char* key, const std::string& only) {
    const json& value = at(key);
    if (value != only) {
      refuse(key, value, fmt::format("must be \"{}\"", only));
    }
  }

  /// A list of so many elements.
  const json& list(const char* key, std::size_t least, std::size_t most) {
    const json& value = at(key);
    if (!value.is_array() || value.size() < least || value.size() > most) {
      const std::string sizes =
          least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
      refuse(key, value, fmt::format("must be a list of {} elements", sizes));
    }
    return value;
  }

  Eigen::VectorXd vector(const char* key, Eigen::Index size) {
    return row(place(key), at(key), size);
  }

  Eigen::MatrixXd matrix(const char* key, Eigen::Index rows, Eigen::Index columns) {
    const json& all = list(key, static_cast<std::size_t>(rows), static_cast<std::size_t>(rows));
    Eigen::MatrixXd found(rows, columns);
    for (Eigen::Index i = 0; i < rows; ++i) {
      found.row(i) =
          row(fmt::format("{}[{}]", place(key), i), all[static_cast<std::size_t>(i)], columns);
    }
    return found;
  }

  /// Refuses keys that were not asked for.
  void finish() const {
    for (const auto& [key, value] : value_.items()) {
      if (std::ranges::find(known_, key) == known_.end()) {
        throw files::ConfigError(
            fmt::format("{}: {}: unknown key{}; allowed: {}", path_, files::printable(place(key)),
                        files::did_you_mean(key, known_), fmt::join(known_, ", ")));
      }
    }
  }

 private:
  std::string place(const std::string& key) const {
    return name_.empty() ? key : name_ + '.' + key;
  }

  [[noreturn]] void fail(const std::string& key, const std::string& reason) const {
    throw files::ConfigError(fmt::format("{}: {}: {}", path_, place(key), reason));
  }

  [[noreturn]] void refuse(const std::string& key, const json& value,
                           const std::string& allowed) const {
    throw files::ConfigError(
        fmt::format("{}: {} = {}: {}", path_, place(key), shown(value), allowed));
  }

  Eigen::VectorXd row(const std::string& where, const json& values, Eigen::Index size) const {
    if (!values.is_array() || values.size() != static_cast<std::size_t>(size)) {
      throw files::ConfigError(fmt::format("{}: {} = {}: must be a list of {} numbers, has {}",
                                           path_, where, shown(values), size,
                                           values.is_array() ? values.size() : 0));
    }
    Eigen::VectorXd found(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const json& value = values[static_cast<std::size_t>(i)];
      const double x = value.is_number() ? value.get<double>() : std::nan("");
      if (!(std::abs(x) <= largest_weight)) {
        throw files::ConfigError(fmt::format("{}: {}[{}] = {}: must be a number from {} to {}",
                                             path_, where, i, shown(value), -largest_weight,
                                             largest_weight));
      }
      found(i) = x;
    }
    return found;
  }

  std::string path_, name_;
  const json& value_;
  std::vector<std::string> known_;
};

/// Refuses what is nested deeper than a network, and keys that are given twice, of which the parser
/// would take the last.
json parsed(const std::string& path, std::string_view text) {
  std::vector<std::set<std::string>> keys;
  const auto refuse = [&](const std::string& reason) {
    throw files::ConfigError(fmt::format("{}: {}", path, reason));
  };
  const auto watch = [&](int depth, json::parse_event_t event, const json& value) {
    if (depth > deepest) {
      refuse(fmt::format("is nested deeper than {} levels, so it is no network", deepest));
    }
    if (event == json::parse_event_t::object_start) {
      keys.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      keys.pop_back();
    } else if (event == json::parse_event_t::key &&
               !keys.back().insert(value.get<std::string>()).second) {
      refuse(fmt::format("{}: is given twice", files::printable(value.get<std::string>())));
    }
    return true;
  };
  try {
    return json::parse(text, watch);
  } catch (const json::exception& error) {
    throw files::ConfigError(
        fmt::format("{}: is no JSON: {}", path, files::printable(error.what())));
  }
}

Gate gate(Object& weights, const std::string& name, int hidden) {
  return {weights.matrix((name + "_input").c_str(), hidden, input_count),
          weights.matrix((name + "_state").c_str(), hidden, hidden),
          weights.vector((name + "_bias").c_str(), hidden)};
}

void read_scales(Object& file, Network& network) {
  struct Expected {
    const char *name, *unit;
  };
  constexpr Expected all[input_count] = {
      {"resistance", "of the first"}, {"power", "W"}, {"stress", "MPa"}};
  const auto read = [](Object& object, const Expected& expected, double& mean, double& scale) {
    object.require_text("name", expected.name);
    object.require_text("unit", expected.unit);
    mean = object.number("mean", -1e9, 1e9);
    scale = object.number("scale", 1e-9, 1e9);
    object.finish();
  };
  for (int i = 0; i < input_count; ++i) {
    Object input = file.element("inputs", static_cast<std::size_t>(i), input_count, input_count);
    read(input, all[i], network.input_mean(i), network.input_scale(i));
  }
  Object output = file.object("output");
  read(output, {"strain", "% of the nominal stroke"}, network.strain_mean_percent,
       network.strain_scale_percent);
}

void read_runs(Object& file, Network& network) {
  constexpr std::size_t most = 1000;
  const std::size_t count = file.list("runs", 1, most).size();
  for (std::size_t i = 0; i < count; ++i) {
    Object run = file.element("runs", i, 1, most);
    network.runs.push_back(
        {run.text("name"), run.whole("rows", 1, std::uint64_t{1} << 48U), run.text("checksum")});
    run.finish();
  }
}

}  // namespace

Network parse_network(const std::string& path, std::string_view text) {
  const json document = parsed(path, text);
  Object file(path, "", document);
  file.require_text("format", "smaservo-gru");
  file.whole("version", version, version);
  Network network{};
  const auto hidden = static_cast<int>(file.whole("hidden", 1, largest_hidden));
  network.step_s = file.number("step_s", 1e-3, 1);
  network.nominal_stroke = file.number("nominal_stroke", 1e-4, 1);
  file.whole("seed", 0, std::uint64_t{1} << 32U);
  file.whole("epochs", 0, std::uint64_t{1} << 32U);
  read_scales(file, network);
  read_runs(file, network);
  Object weights = file.object("weights");
  network.reset = gate(weights, "reset", hidden);
  network.update = gate(weights, "update", hidden);
  network.candidate = gate(weights, "candidate", hidden);
  network.output = weights.vector("output", hidden);
  network.output_bias = weights.number("output_bias", -largest_weight, largest_weight);
  weights.finish();
  file.finish();
  return network;
}

Network load_network(const std::string& path) {
  std::error_code error;
  // Of a device or a pipe, nobody knows how much will come.
  if (std::filesystem::exists(path, error) && !std::filesystem::is_directory(path, error)) {
    const bool regular = std::filesystem::is_regular_file(path, error);
    if (!regular || std::filesystem::file_size(path, error) > largest_file) {
      throw files::ConfigError(
          fmt::format("{}: must be a file of at most {} MiB", path, largest_file >> 20U));
    }
  }
  return parse_network(path, files::whole_file(path));
}

}  // namespace smaservo::gru

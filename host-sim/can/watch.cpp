#include "host-sim/can/watch.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "firmware/canopen/node/index.hpp"
#include "host-sim/report/text_plot.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::can {
namespace {

constexpr std::size_t plot_width = 64;
constexpr std::size_t plot_height = 12;

constexpr std::array<const char*, 8> usual{"6041",
                                           "live.position_m",
                                           "live.setpoint",
                                           "live.wire_temperature_K",
                                           "live.drive_current_A",
                                           "live.power_W",
                                           "live.resistance_ohm",
                                           "live.stress_Pa"};

struct Row {
  double time_s;
  std::vector<std::string> texts, words;
};

constexpr Key statusword{canopen::index::statusword, 0};

/// The meaning of a code, in words.
std::string words_of(const text::KnownObject& object, const Bytes& bytes) {
  return object.key == statusword
             ? fmt::format("  {}",
                           drive_state_text(static_cast<unsigned>(canopen::take_number(bytes))))
             : "";
}

std::string table(const std::vector<text::KnownObject>& objects, const Row& row) {
  files::TextTable table({{""}, {""}});
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table.add({objects[i].name, row.texts[i] + row.words[i]});
  }
  return table.text();
}

std::vector<text::KnownObject> chosen_objects(const std::vector<std::string>& names) {
  std::vector<text::KnownObject> objects;
  for (const std::string& name : names) {
    objects.push_back(text::find_object(name));
    if (objects.back().name.empty()) {
      objects.back().name = name;
    }
  }
  return objects;
}

/// The index of the object to plot, which is added if it is missing; if there is none to plot, the
/// number of objects.
std::size_t place_of_plot(const std::string& name, std::vector<text::KnownObject>& objects) {
  if (name.empty()) {
    return objects.size();
  }
  const text::KnownObject wanted = text::find_object(name);
  const auto found = std::ranges::find(objects, wanted.key, &text::KnownObject::key);
  const auto place = static_cast<std::size_t>(found - objects.begin());
  if (place == objects.size()) {
    objects.push_back(wanted);
  }
  return place;
}

std::string header(const std::vector<text::KnownObject>& objects) {
  std::string text = "time_s";
  for (const text::KnownObject& object : objects) {
    text += "," + object.name;
  }
  return text + '\n';
}

}  // namespace

void watch(Remote& remote, const WatchPlan& plan, bool in_place,
           const std::function<void(const std::string&)>& show) {
  std::vector<text::KnownObject> objects = chosen_objects(
      plan.names.empty() ? std::vector<std::string>(usual.begin(), usual.end()) : plan.names);
  const std::size_t plotted = place_of_plot(plan.plot, objects);
  if (!in_place) {
    show(header(objects));
  }
  std::vector<double> history;
  const std::int64_t start_us = remote.bus().now_us();
  const auto period_us = static_cast<std::int64_t>(plan.period_s * 1e6);
  for (std::uint64_t i = 0; plan.count == 0 || i < plan.count; ++i) {
    hal::CanFrame passing;
    while (remote.bus().receive(passing, start_us + static_cast<std::int64_t>(i) * period_us)) {
    }
    Row row{static_cast<double>(remote.bus().now_us() - start_us) * 1e-6, {}, {}};
    for (std::size_t k = 0; k < objects.size(); ++k) {
      const Bytes bytes = remote.read(objects[k]);
      row.texts.push_back(text::value_text(objects[k], bytes));
      row.words.push_back(words_of(objects[k], bytes));
      if (k == plotted) {
        history.push_back(text::value_number(objects[k], bytes));
      }
    }
    if (history.size() > plot_width) {
      history.erase(history.begin());
    }
    const std::string plot = plotted < objects.size()
                                 ? "\n" + objects[plotted].name + "\n" +
                                       report::text_plot({history}, plot_width, plot_height)
                                 : "";
    const bool last = i + 1 == plan.count;
    show(in_place ? table(objects, row) + plot
                  : fmt::format("{:.3f},{}\n{}", row.time_s, fmt::join(row.texts, ","),
                                last ? plot : ""));
  }
}

}  // namespace smaservo::can

#include "host-sim/can/watch.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host-sim/can/text_plot.hpp"

namespace smaservo::can {
namespace {

constexpr std::size_t plot_width = 64;
constexpr std::size_t plot_height = 12;
constexpr const char* to_the_top = "\x1b[H\x1b[J";

const std::vector<std::string> usual{
    "6041",           "live.position_m", "live.setpoint",       "live.temperature_K",
    "live.current_A", "live.power_W",    "live.resistance_ohm", "live.stress_Pa"};

struct Row {
  double time_s;
  std::vector<std::string> texts;
};

std::string table(const std::vector<KnownObject>& objects, const Row& row) {
  std::string text;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    text += fmt::format("{:<32} {}\n", objects[i].name, row.texts[i]);
  }
  return text;
}

}  // namespace

void watch(Remote& remote, const WatchPlan& plan, bool in_place,
           const std::function<void(const std::string&)>& show) {
  std::vector<KnownObject> objects;
  for (const std::string& name : plan.names.empty() ? usual : plan.names) {
    objects.push_back(find_object(name));
    if (objects.back().name.empty()) objects.back().name = name;
  }
  std::size_t plotted = objects.size();
  if (!plan.plot.empty()) {
    objects.push_back(find_object(plan.plot));
    const auto first = std::ranges::find(objects, objects.back().key, &KnownObject::key);
    plotted = static_cast<std::size_t>(first - objects.begin());
    if (plotted + 1 < objects.size()) objects.pop_back();
  }
  if (!in_place) {
    std::vector<std::string> names;
    for (const KnownObject& object : objects) names.push_back(object.name);
    show(fmt::format("time_s,{}\n", fmt::join(names, ",")));
  }
  std::vector<double> history;
  const std::int64_t start_us = remote.bus().now_us();
  const auto period_us = static_cast<std::int64_t>(plan.period_s * 1e6);
  for (std::uint64_t i = 0; plan.count == 0 || i < plan.count; ++i) {
    CanFrame passing;
    while (remote.bus().receive(passing, start_us + static_cast<std::int64_t>(i) * period_us)) {
    }
    Row row{static_cast<double>(remote.bus().now_us() - start_us) * 1e-6, {}};
    for (std::size_t k = 0; k < objects.size(); ++k) {
      const Bytes bytes = remote.read(objects[k]);
      row.texts.push_back(value_text(objects[k], bytes));
      if (k == plotted) history.push_back(value_number(objects[k], bytes));
    }
    if (history.size() > plot_width) history.erase(history.begin());
    const std::string plot =
        plotted < objects.size()
            ? "\n" + objects[plotted].name + "\n" + text_plot(history, plot_width, plot_height)
            : "";
    const bool last = i + 1 == plan.count;
    show(in_place ? to_the_top + table(objects, row) + plot
                  : fmt::format("{:.3f},{}\n{}", row.time_s, fmt::join(row.texts, ","),
                                last ? plot : ""));
  }
}

}  // namespace smaservo::can

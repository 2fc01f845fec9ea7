#include "host-sim/report/panel_json.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host-sim/report/thin.hpp"
#include "model/files/message.hpp"

namespace smaservo::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t rows_of_a_panel = 20'000;
constexpr std::size_t max_numbers = 300'000;

/// The columns of a page. Those of one series are thinned together, so that rows are preserved.
class PageColumns {
 public:
  std::size_t place_of(const Column& values, bool along_x) {
    const auto [known, fresh] = places_.try_emplace(values.get(), all_.size());
    if (fresh) {
      all_.push_back({values.get(), all_.size(), false});
    }
    all_[known->second].along_x = all_[known->second].along_x || along_x;
    return known->second;
  }

  void share_rows(std::size_t a, std::size_t b) {
    if (all_[a].values->size() != all_[b].values->size()) {
      throw std::logic_error("columns of different lengths");
    }
    all_[group_of(a)].group = group_of(b);
  }

  std::string json() {
    std::map<std::size_t, std::vector<const std::vector<double>*>> groups;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      groups[group_of(i)].push_back(all_[i].values);
    }
    std::map<std::size_t, std::vector<std::size_t>> rows;
    for (const auto& [group, columns] : groups) {
      rows[group] = rows_to_show(columns, std::min(rows_of_a_panel, max_numbers / columns.size()));
    }
    std::string text;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      text += text.empty() ? "[" : ",\n[";
      append(text, all_[i], rows[group_of(i)]);
      text += ']';
    }
    return text;
  }

 private:
  struct One {
    const std::vector<double>* values;
    std::size_t group;
    bool along_x;
  };

  std::size_t group_of(std::size_t place) const {
    while (all_[place].group != place) {
      place = all_[place].group;
    }
    return place;
  }

  static void append(std::string& text, const One& column, const std::vector<std::size_t>& rows) {
    const char* separator = "";
    for (const std::size_t row : rows) {
      const double value = (*column.values)[row];
      text += separator;
      text += std::isfinite(value) ? fmt::format("{:.{}g}", value, column.along_x ? 9 : 6) : "null";
      separator = ",";
    }
  }

  std::vector<One> all_;
  std::map<const std::vector<double>*, std::size_t> places_;
};

constexpr const char* kind_names[] = {"line", "steps", "points", "band", "area", "spans"};

/// Writes a member only if it differs from its default.
void put(Json& json, const char* key, const std::string& text) {
  if (!text.empty()) {
    json[key] = files::printable(text);
  }
}
void put(Json& json, const char* key, bool flag) {
  if (flag) {
    json[key] = true;
  }
}
void put(Json& json, const char* key, double value, double usual = as_the_data) {
  if (std::isfinite(value) && value != usual) {
    json[key] = std::stod(fmt::format("{:.9g}", value));
  }
}

Json axis_json(const Axis& axis) {
  Json json = Json::object();
  put(json, "label", axis.label);
  put(json, "min", axis.min);
  put(json, "max", axis.max);
  put(json, "log", axis.log);
  for (const auto& [at, name] : axis.ticks) {
    json["ticks"].push_back({at, files::printable(name)});
  }
  return json;
}

Json series_json(const Series& series, PageColumns& columns) {
  Json json{{"kind", kind_names[static_cast<std::size_t>(series.kind)]}};
  put(json, "name", series.name);
  put(json, "colour", series.colour);
  const std::size_t x = columns.place_of(series.x, true);
  json["x"] = x;
  const auto add = [&](const char* key, const Column& values, bool along_x) {
    if (values != nullptr) {
      const std::size_t place = columns.place_of(values, along_x);
      columns.share_rows(x, place);
      json[key] = place;
    }
  };
  add("y", series.y, series.kind == Kind::spans);
  add("low", series.low, false);
  add("at", series.at, true);
  put(json, "right", series.right);
  put(json, "width", series.width, 1);
  put(json, "dashed", series.dashed);
  return json;
}

Json panel_json(const Panel& panel, PageColumns& columns) {
  if (!panel.svg.empty()) {
    return nullptr;
  }
  Json json = Json::object();
  put(json, "title", panel.title);
  put(json, "half", panel.half_width);
  json["height"] = panel.height;
  json["x"] = axis_json(panel.x);
  json["y"] = axis_json(panel.y);
  json["right"] = axis_json(panel.right);
  put(json, "link", panel.link);
  put(json, "follows", panel.follows);
  put(json, "equal", panel.equal);
  json["series"] = Json::array();
  for (const Series& series : panel.series) {
    json["series"].push_back(series_json(series, columns));
  }
  json["rules"] = Json::array();
  for (const Rule& rule : panel.rules) {
    Json one = Json::object();
    put(one, "at", rule.at);
    put(one, "name", rule.name);
    put(one, "colour", rule.colour);
    put(one, "vertical", rule.vertical);
    json["rules"].push_back(one);
  }
  json["notes"] = Json::array();
  for (const Note& note : panel.notes) {
    json["notes"].push_back({note.x, note.y, files::printable(note.text)});
  }
  return json;
}

}  // namespace

std::string panels_json(std::span<const Panel> panels) {
  PageColumns columns;
  Json all = Json::array();
  for (const Panel& panel : panels) {
    all.push_back(panel_json(panel, columns));
  }
  const std::string text = fmt::format("{{\"columns\":[{}],\n\"panels\":{}}}", columns.json(),
                                       all.dump(-1, ' ', false, Json::error_handler_t::replace));
  // The escapes keep any text from ending the script element or beginning a comment in it.
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    c == '<' ? safe += "\\u003c" : safe += c;
  }
  return safe;
}

}  // namespace smaservo::report

#include "hal/recording/mcap/rows_reader.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hal/recording/mcap/row_object.hpp"

namespace smaservo::hal::mcap {
namespace {

constexpr std::string_view usual_topic = "/trace";
constexpr std::string_view readable = "json";

/// Whether a text can be a field or a name of a CSV file.
bool fits_csv(std::string_view text) {
  return text.find_first_of(",\n") == std::string_view::npos && !text.ends_with('\r');
}

}  // namespace

RowsReader::RowsReader(Reader::Source source, std::string topic)
    : topic_(std::move(topic)), reader_(std::move(source)) {}

void RowsReader::fail(const Message& message, std::string_view what) const {
  throw Malformed(message.offset, fmt::format("message {}: {}", messages_, what));
}

void RowsReader::fail_without_rows() const {
  std::vector<std::string> all;
  for (const auto& [id, channel] : reader_.channels()) {
    all.push_back(fmt::format("{} ({})", channel.topic, channel.encoding));
  }
  const std::string wanted = topic_.empty() ? "" : " " + topic_;
  throw files::UserError(
      fmt::format("has no channel{} with message encoding json; channels: {}{}{}", wanted,
                  all.empty() ? "none" : fmt::format("{}", fmt::join(all, ", ")),
                  reader_.cut_off().empty() ? "" : "; ", reader_.cut_off()));
}

bool RowsReader::is_chosen(const Channel& channel) const {
  return channel.encoding == readable && (topic_.empty() || channel.topic == topic_);
}

/// Without a given topic the first message's is chosen, provided that no other topic has messages.
void RowsReader::choose(const Message& message) {
  const std::string& topic = reader_.channels().at(message.channel).topic;
  if (chosen_.empty()) {
    chosen_ = topic;
  } else if (chosen_ != topic) {
    fail(message, fmt::format("is of {}, those before of {}: choose one by `host-sim convert "
                              "--topic`",
                              topic, chosen_));
  }
}

bool RowsReader::next_message(Message& message) {
  while (reader_.next(message)) {
    const Channel& channel = reader_.channels().at(message.channel);
    if (topic_.empty() && channel.topic == usual_topic) {
      topic_ = usual_topic;
    }
    if (is_chosen(channel)) {
      ++messages_;
      choose(message);
      return true;
    }
  }
  return false;
}

const TraceColumns& RowsReader::columns() {
  if (!begun_) {
    begun_ = true;
    Message message;
    if (next_message(message)) {
      begin(message);
      first_ = message;
    } else {
      // A trace without rows still has its columns.
      const auto& all = reader_.channels();
      const auto found =
          std::ranges::find_if(all, [&](const auto& entry) { return is_chosen(entry.second); });
      if (found == all.end()) {
        fail_without_rows();
      }
      message.channel = found->first;
      begin(message);
    }
    if (columns_.empty()) {
      fail(message, "has no columns");
    }
  }
  return columns_;
}

void RowsReader::begin(const Message& message) {
  const auto schema = reader_.schemas().find(reader_.channels().at(message.channel).schema);
  if (schema != reader_.schemas().end() && schema->second.encoding == "jsonschema") {
    try {
      for (const TraceColumn& column : columns_of(schema->second.data)) {
        add_column(message, column.name, column.kind);
      }
    } catch (const Malformed&) {
      throw;
    } catch (const files::UserError& problem) {
      fail(message, fmt::format("schema {}: {}", schema->second.name, problem.what()));
    }
  }
  if (!columns_.empty()) {
    return;
  }
  RowObject object(message.data);
  for (Member member; object.next(member);) {
    add_column(message, member.name, Kind::unknown);
  }
  if (!object.problem().empty() && !message.data.empty()) {
    fail(message, object.problem());
  }
}

void RowsReader::add_column(const Message& message, std::string_view name, Kind kind) {
  if (!fits_csv(name)) {
    fail(message, fmt::format("column '{}': a name cannot have a comma or a line break", name));
  }
  if (!positions_.emplace(name, columns_.size()).second) {
    fail(message, fmt::format("column {} is there twice", name));
  }
  columns_.push_back({std::string(name), kind});
  fields_.emplace_back();
  given_.push_back(0);
}

std::string RowsReader::header() {
  std::string text;
  for (const TraceColumn& column : columns()) {
    text += text.empty() && &column == columns_.data() ? "" : ",";
    text += column.name;
  }
  return text;
}

/// The position of the column; the search begins at `expected`, as members usually come in the
/// order of columns.
std::size_t RowsReader::column(const Message& message, std::string_view name,
                               std::size_t expected) const {
  for (std::size_t i = expected; i < columns_.size(); ++i) {
    if (columns_[i].name == name) {
      return i;
    }
  }
  const auto found = positions_.find(std::string(name));
  if (found == positions_.end()) {
    fail(message, fmt::format("has {}, which is not among the columns: {}", name, [&] {
           std::vector<std::string_view> names;
           for (const TraceColumn& known : columns_) {
             names.push_back(known.name);
           }
           return fmt::format("{}", fmt::join(names, ", "));
         }()));
  }
  return found->second;
}

bool RowsReader::next(std::string& row) {
  columns();
  Message message;
  if (first_) {
    message = *first_;
    first_.reset();
  } else if (!next_message(message)) {
    return false;
  }
  RowObject object(message.data);
  std::size_t expected = 0;
  for (Member member; object.next(member);) {
    const std::size_t at = column(message, member.name, expected);
    if (given_[at] == messages_) {
      fail(message, fmt::format("has {} twice", member.name));
    }
    if (!fits_csv(member.value)) {
      fail(message, fmt::format("{}: '{}' has a comma or a line break, which a trace cannot have",
                                member.name, member.value));
    }
    given_[at] = messages_;
    fields_[at] = member.value;
    expected = at + 1;
  }
  if (!object.problem().empty()) {
    fail(message, object.problem());
  }
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    row += i == 0 ? "" : ",";
    if (given_[i] == messages_) {
      row += fields_[i];
    }
  }
  return true;
}

std::size_t CsvOfRows::read(char* to, std::size_t size) {
  constexpr std::size_t enough = std::size_t{1} << 16U;
  if (given_ == text_.size()) {
    text_.clear();
    given_ = 0;
    if (!has_header_) {
      has_header_ = true;
      text_ = rows_.header() + "\n";
    }
    while (text_.size() < enough && rows_.next(text_)) {
      text_ += '\n';
    }
  }
  const std::size_t part = std::min(size, text_.size() - given_);
  std::memcpy(to, text_.data() + given_, part);
  given_ += part;
  return part;
}

}  // namespace smaservo::hal::mcap

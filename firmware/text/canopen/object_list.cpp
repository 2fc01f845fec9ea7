#include "firmware/text/canopen/object_list.hpp"

#include <map>

#include "firmware/canopen/node/communication.hpp"
#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/parameters/parameters.hpp"
#include "firmware/signals.hpp"

namespace smaservo::text {
namespace {

using canopen::Type;

std::string index_name(std::uint16_t index) {
  for (const canopen::IndexName& row : canopen::communication_names) {
    if (row.index == index) {
      return std::string(row.name);
    }
  }
  for (const canopen::IndexName& row : canopen::drive_object_names) {
    if (row.index == index) {
      return std::string(row.name);
    }
  }
  return index == live_values ? "Live values" : "";
}

class List {
 public:
  void add(const ListedObject& object) {
    const std::uint16_t index = object.object.key.index;
    ListedIndex& listed = all_[index];
    listed.index = index;
    listed.objects.push_back(object);
    if (listed.name.empty()) {
      listed.name =
          object.object.key.sub == 0 && index_name(index).empty() ? object.name : index_name(index);
    }
  }
  void name(std::uint16_t index, const std::string& name) { all_[index].name = name; }
  std::vector<ListedIndex> take() {
    std::vector<ListedIndex> list;
    list.reserve(all_.size());
    for (auto& [index, listed] : all_) {
      list.push_back(std::move(listed));
    }
    return list;
  }

 private:
  std::map<std::uint16_t, ListedIndex> all_;
};

void add_parameters(List& list) {
  for (const Parameter<double>& row : parameters<double>) {
    const std::string path(row.path.text());
    const auto access =
        static_cast<std::uint16_t>(canopen::readable | canopen::written_at(row.level));
    list.add({{row.key, type_of(row.type), access, canopen::nowhere, row.standard.bits,
               row.min.bits, row.max.bits},
              path,
              std::string(row.meaning),
              row.has_default(),
              true});
    // The table of the first row; later ones may be in a table within that.
    if (row.key.sub == 1) {
      list.name(row.key.index, path.substr(0, path.rfind('.')));
    }
  }
}

void add_signals(List& list) {
  for (std::size_t i = 0; i < signal_count; ++i) {
    const Signal<double>& signal = signal_rows<double>[i];
    const canopen::DescribedObject d =
        canopen::row({live_values, sub_of(i)}, Type::real, canopen::readable | canopen::in_tpdo,
                     canopen::nowhere, signal.name);
    list.add({d.object, std::string(signal.name), std::string(signal.meaning), false});
  }
}

}  // namespace

Type type_of(ValueType type) {
  switch (type) {
    case ValueType::real:
      return Type::real;
    case ValueType::number:
      return Type::u32;
    case ValueType::choice:
      return Type::u8;
    case ValueType::boolean:
      break;
  }
  return Type::boolean;
}

std::string_view type_text(Type type) {
  switch (type) {
    case Type::boolean:
      return "BOOLEAN";
    case Type::i8:
      return "INTEGER8";
    case Type::i16:
      return "INTEGER16";
    case Type::i32:
      return "INTEGER32";
    case Type::u8:
      return "UNSIGNED8";
    case Type::u16:
      return "UNSIGNED16";
    case Type::u32:
      return "UNSIGNED32";
    case Type::real:
      return "REAL32";
    case Type::text:
      return "VISIBLE_STRING";
    default:
      return "DOMAIN";
  }
}

std::vector<ListedIndex> list_objects() {
  List list;
  const auto add_rows = [&](std::span<const canopen::DescribedObject> rows) {
    for (const canopen::DescribedObject& row : rows) {
      list.add({row.object, std::string(row.name), std::string(row.meaning)});
    }
  };
  add_rows(canopen::communication_rows);
  add_rows(canopen::drive_object_rows);
  add_signals(list);
  add_parameters(list);
  return list.take();
}

}  // namespace smaservo::text

#include "firmware/text/canopen/canopen_reference.hpp"

#include <fmt/format.h>

#include "firmware/canopen/node/communication.hpp"
#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/text/canopen/object_list.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::text {
namespace {

namespace index = canopen::index;

using canopen::Object;
using canopen::Type;

bool may(const Object& object, unsigned right) {
  return (object.access & right) != 0;
}

// EDS.

std::string_view access_text(const Object& object) {
  using namespace canopen;
  if (may(object, constant)) {
    return "const";
  }
  if (!may(object, writable)) {
    return "ro";
  }
  return !may(object, readable) ? "wo" : may(object, in_rpdo) ? "rww" : "rw";
}

std::string number_text(Type type, std::uint32_t value) {
  return canopen::is_signed(type) ? fmt::format("{}", static_cast<std::int32_t>(value))
                                  : fmt::format("0x{:X}", value);
}

/// An object's value after a restore.
std::string default_text(const ListedObject& listed) {
  const Object& object = listed.object;
  switch (object.key.index) {
    case index::device_type:
      return fmt::format("0x{:X}", canopen::servo_device_type);
    case index::device_name:
      return "smaservo";
    case index::identity: {
      constexpr std::array<std::uint32_t, 4> identity{0, canopen::servo_product,
                                                      canopen::servo_revision, 0};
      return fmt::format("0x{:X}", identity.at(object.key.sub - 1U));
    }
    default:
      break;
  }
  if (object.type == Type::real) {
    return fmt::format("{}", listed.has_default ? canopen::as_real(object.standard) : 0.F);
  }
  if (!listed.has_default || canopen::size_of(object.type) == 0) {
    return "";
  }
  const std::string number = number_text(object.type, object.standard);
  return may(object, canopen::by_node) ? "$NODEID+" + number : number;
}

std::string limits_text(const Object& object) {
  std::string text;
  if (object.type == Type::real || canopen::size_of(object.type) == 0 ||
      object.type == Type::boolean) {
    return text;
  }
  if (object.min != canopen::min_of(object.type)) {
    text += fmt::format("LowLimit={}\n", number_text(object.type, object.min));
  }
  if (object.max != canopen::max_of(object.type)) {
    text += fmt::format("HighLimit={}\n", number_text(object.type, object.max));
  }
  return text;
}

std::string variable_text(const std::string& section, const ListedObject& listed,
                          RealDefaults reals) {
  const Object& object = listed.object;
  const bool told = object.type != Type::real || reals == RealDefaults::decimal;
  const std::string standard = told ? default_text(listed) : "";
  const bool is_domain = object.type == Type::domain;
  std::string text = fmt::format(
      "[{}]\nParameterName={}\nObjectType=0x{:X}\nDataType=0x{:04X}\nAccessType={}\n", section,
      listed.name, is_domain ? 0x2 : 0x7, static_cast<unsigned>(object.type), access_text(object));
  if (!standard.empty()) {
    text += fmt::format("DefaultValue={}\n", standard);
  }
  text += limits_text(object);
  // Readers of EDS refuse the key PDOMapping for a domain, even with the value 0.
  if (!is_domain) {
    text +=
        fmt::format("PDOMapping={}\n", may(object, canopen::in_rpdo | canopen::in_tpdo) ? 1 : 0);
  }
  return text + '\n';
}

std::string index_text(const ListedIndex& listed, RealDefaults reals) {
  const std::string section = fmt::format("{:04X}", listed.index);
  if (listed.is_variable()) {
    return variable_text(section, listed.objects[0], reals);
  }
  const bool counts_itself = listed.objects[0].object.key.sub == 0;
  const std::size_t subs = listed.objects.size() + (counts_itself ? 0 : 1);
  const bool is_array =
      listed.index == index::error_field || listed.index == index::store_parameters ||
      listed.index == index::restore_defaults || listed.index == index::heartbeat_consumer;
  std::string text = fmt::format("[{}]\nParameterName={}\nObjectType=0x{:X}\nSubNumber=0x{:X}\n\n",
                                 section, listed.name, is_array ? 0x8 : 0x9, subs);
  if (!counts_itself) {
    text += fmt::format(
        "[{}sub0]\nParameterName=Highest sub-index supported\nObjectType=0x7\nDataType=0x0005\n"
        "AccessType=const\nDefaultValue=0x{:X}\nPDOMapping=0\n\n",
        section, listed.highest_sub());
  }
  for (const ListedObject& object : listed.objects) {
    text += variable_text(fmt::format("{}sub{:X}", section, object.object.key.sub), object, reals);
  }
  return text;
}

bool is_mandatory(std::uint16_t index) {
  return index == index::device_type || index == index::error_register || index == index::identity;
}
bool is_manufacturers(std::uint16_t index) {
  return 0x2000 <= index && index <= 0x5FFF;
}

template <class Of>
std::string group_text(std::string_view name, const std::vector<ListedIndex>& all,
                       RealDefaults reals, Of of) {
  std::string list;
  std::string objects;
  int n = 0;
  for (const ListedIndex& listed : all) {
    if (of(listed.index)) {
      list += fmt::format("{}=0x{:04X}\n", ++n, listed.index);
      objects += index_text(listed, reals);
    }
  }
  return fmt::format("[{}]\nSupportedObjects={}\n{}\n", name, n, list) + objects;
}

constexpr std::string_view eds_head = R"([FileInfo]
FileName=smaservo.eds
FileVersion=1
FileRevision=0
EDSVersion=4.0
Description=Position servo of a shape-memory-alloy wire
CreationTime=12:00PM
CreationDate=01-01-2026
CreatedBy=host-sim describe eds
ModificationTime=12:00PM
ModificationDate=01-01-2026
ModifiedBy=host-sim describe eds

[DeviceInfo]
VendorName=smaservo
VendorNumber=0x0
ProductName=smaservo
)";

constexpr std::string_view eds_device = R"(OrderCode=smaservo
BaudRate_10=1
BaudRate_20=1
BaudRate_50=1
BaudRate_125=1
BaudRate_250=1
BaudRate_500=1
BaudRate_800=1
BaudRate_1000=1
SimpleBootUpMaster=0
SimpleBootUpSlave=1
Granularity=8
DynamicChannelsSupported=0
CompactPDO=0
GroupMessaging=0
NrOfRXPDO=4
NrOfTXPDO=4
LSS_Supported=1

[DummyUsage]
Dummy0001=0
Dummy0002=1
Dummy0003=1
Dummy0004=1
Dummy0005=1
Dummy0006=1
Dummy0007=1

)";

std::string comments(RealDefaults reals) {
  return fmt::format(
      "[Comments]\nLines=2\nLine1=Made by host-sim describe eds from the tables of the firmware.\n"
      "Line2=REAL32 objects have {} here: see OBJECTS.md.\n\n",
      reals == RealDefaults::none ? "neither default nor limits"
                                  : "decimal defaults and no limits");
}

// DBC.

struct BusFrame {
  std::uint32_t id;
  std::string name;
  bool from_device;
  std::array<std::uint32_t, 3> map;
};

const ListedObject& object_of(const std::vector<ListedIndex>& all, std::uint32_t mapped) {
  const Key key{static_cast<std::uint16_t>(mapped >> 16U), static_cast<std::uint8_t>(mapped >> 8U)};
  for (const ListedIndex& listed : all) {
    for (const ListedObject& object : listed.objects) {
      if (object.object.key == key) {
        return object;
      }
    }
  }
  throw std::logic_error("a default mapping names no object");
}

std::string signal_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  }
  return out;
}

std::string_view unit_of(const ListedObject& listed) {
  if (listed.meaning == "um" || listed.meaning == "um/s") {
    return listed.meaning;
  }
  const std::size_t at = listed.name.rfind('_');
  const bool live = listed.object.key.index == 0x2200 && at != std::string::npos;
  return live ? std::string_view(listed.name).substr(at + 1) : "";
}

struct DbcFrame {
  std::string message, types;
};

DbcFrame dbc_frame(const std::vector<ListedIndex>& all, const BusFrame& frame) {
  DbcFrame text;
  unsigned bit = 0;
  for (const std::uint32_t mapped : frame.map) {
    if (mapped == 0) {
      continue;
    }
    const ListedObject& listed = object_of(all, mapped);
    const unsigned bits = mapped & 0xFFU;
    const bool real = listed.object.type == Type::real;
    const std::string name = signal_name(listed.name);
    text.message += fmt::format(" SG_ {} : {}|{}@1{} (1,0) [0|0] \"{}\" {}\n", name, bit, bits,
                                real || canopen::is_signed(listed.object.type) ? '-' : '+',
                                unit_of(listed), frame.from_device ? "Master" : "Smaservo");
    if (real) {
      text.types += fmt::format("SIG_VALTYPE_ {} {} : 1;\n", frame.id, name);
    }
    bit += bits;
  }
  text.message = fmt::format("BO_ {} {}: {} {}\n", frame.id, frame.name, bit / 8,
                             frame.from_device ? "Smaservo" : "Master") +
                 text.message + "\n";
  return text;
}

constexpr std::string_view dbc_head = R"(VERSION ""

NS_ :

BS_:

BU_: Master Smaservo

BO_ 0 NMT: 2 Master
 SG_ Command : 0|8@1+ (1,0) [0|255] "" Smaservo
 SG_ Node_id : 8|8@1+ (1,0) [0|127] "" Smaservo

BO_ 128 SYNC: 0 Master

BO_ 129 EMCY: 8 Smaservo
 SG_ Error_code : 0|16@1+ (1,0) [0|65535] "" Master
 SG_ Error_register : 16|8@1+ (1,0) [0|255] "" Master
 SG_ Fault : 24|8@1+ (1,0) [0|255] "" Master

BO_ 1793 Heartbeat: 1 Smaservo
 SG_ State : 0|7@1+ (1,0) [0|127] "" Master

)";

constexpr std::string_view dbc_tail =
    R"(VAL_ 0 Command 1 "start" 2 "stop" 128 "pre-operational" 129 "reset node" 130 "reset communication" ;
VAL_ 1793 State 0 "boot-up" 4 "stopped" 5 "operational" 127 "pre-operational" ;
)";

// Markdown.

std::string real_default(const ListedObject& listed) {
  if (listed.object.type != Type::real || !may(listed.object, canopen::writable)) {
    return default_text(listed);
  }
  return listed.has_default ? fmt::format("{}", canopen::as_real(listed.object.standard)) : "none";
}

std::string pdo_text(const Object& object) {
  const bool in = may(object, canopen::in_rpdo), out = may(object, canopen::in_tpdo);
  return in && out ? "RPDO, TPDO" : in ? "RPDO" : out ? "TPDO" : "";
}

std::string table_text(const ListedIndex& listed) {
  files::TextTable table(
      {{"Object"}, {"Name"}, {"Type"}, {"Access"}, {"Level"}, {"PDO"}, {"Default"}, {"Meaning"}});
  for (const ListedObject& object : listed.objects) {
    const Object& o = object.object;
    table.add({fmt::format("{:04X}h:{}", o.key.index, o.key.sub), object.name, type_text(o.type),
               fmt::format("{}{}", access_text(o), may(o, canopen::stored) ? ", stored" : ""),
               may(o, canopen::writable)
                   ? level_names[static_cast<std::size_t>(canopen::level_of(o.access))]
                   : "",
               pdo_text(o), real_default(object), object.meaning});
  }
  return table.markdown();
}

}  // namespace

std::string eds_text(RealDefaults reals) {
  const std::vector<ListedIndex> all = list_objects();
  std::string text(eds_head);
  text += fmt::format("ProductNumber=0x{:X}\nRevisionNumber=0x{:X}\n", canopen::servo_product,
                      canopen::servo_revision);
  text += eds_device;
  text += comments(reals);
  text += group_text("MandatoryObjects", all, reals, is_mandatory);
  text += group_text("OptionalObjects", all, reals, [](std::uint16_t index) {
    return !is_mandatory(index) && !is_manufacturers(index);
  });
  text += group_text("ManufacturerObjects", all, reals, is_manufacturers);
  text.pop_back();  // the blank line after the last section
  return text;
}

std::string dbc_text() {
  constexpr std::uint32_t node_id = 1;
  const std::vector<ListedIndex> all = list_objects();
  std::string text(dbc_head), types;
  const auto add = [&](const canopen::detail::PdoDefaults& pdo, std::string_view name,
                       std::size_t i, bool from_device) {
    if (pdo.map[0] == 0) {
      return;
    }
    const DbcFrame frame = dbc_frame(all, {(pdo.cob & 0x7FFU) + node_id,
                                           fmt::format("{}{}", name, i + 1), from_device, pdo.map});
    text += frame.message;
    types += frame.types;
  };
  for (std::size_t i = 0; i < canopen::pdo_count; ++i) {
    add(canopen::detail::tpdo_defaults[i], "TPDO", i, true);
    add(canopen::detail::rpdo_defaults[i], "RPDO", i, false);
  }
  return text + std::string(dbc_tail) + types;
}

std::string object_reference() {
  std::string text =
      "# Objects\n\nMade by `host-sim describe objects` from the tables of the firmware; not to be "
      "edited. The parameters\n(2000h to 211Ch) are in [PARAMETERS.md](PARAMETERS.md), all others "
      "are here. *Stored*: kept by 1010h in\nthe image of the bus.\n";
  for (const ListedIndex& listed : list_objects()) {
    if (!listed.objects.front().is_parameter) {
      text += fmt::format("\n## {:04X}h {}\n\n", listed.index, listed.name) + table_text(listed);
    }
  }
  return text;
}

}  // namespace smaservo::text

#pragma once
// The communication objects of CiA 301 as a plain struct, and the table that describes them.

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/objects.hpp"

namespace smaservo::canopen {

inline constexpr std::size_t pdo_count = 4;     ///< PDOs in each direction
inline constexpr std::size_t mapped_count = 8;  ///< greatest number of objects in a PDO
inline constexpr std::size_t consumer_count = 4;
inline constexpr std::size_t error_history = 8;

/// The communication parameters of a PDO, 1400h or 1800h.
struct PdoParams {
  std::uint32_t cob;
  std::uint16_t inhibit_100us;
  std::uint16_t event_ms;
  std::uint8_t type;
  std::uint8_t sync_start;
};

/// The mapping of a PDO, 1600h or 1A00h: index, sub-index, bits.
struct Mapping {
  std::array<std::uint32_t, mapped_count> objects;
  std::uint8_t count;
};

struct Communication {
  std::uint32_t device_type;
  std::array<std::uint32_t, 4> identity;
  std::array<std::uint32_t, error_history> errors;
  std::uint32_t sync_cob, sync_period_us;
  std::uint32_t emergency_cob;
  std::array<std::uint32_t, consumer_count> consumers;
  std::array<std::uint32_t, 2> verify;
  std::array<std::uint32_t, 2> sdo_cob;
  std::array<PdoParams, pdo_count> rpdo, tpdo;
  std::array<Mapping, pdo_count> rpdo_map, tpdo_map;
  std::uint16_t emergency_inhibit_100us, heartbeat_ms;
  std::uint8_t error_register, error_count, sync_overflow, error_behaviour;
};

inline constexpr std::uint32_t cob_invalid = 0x8000'0000;
inline constexpr std::uint32_t cob_id_mask = 0x7FF;
inline constexpr std::uint32_t cob_no_remote = 0x4000'0000;
inline constexpr std::uint32_t store_signature = 0x65766173;    ///< "save"
inline constexpr std::uint32_t restore_signature = 0x64616F6C;  ///< "load"

/// An object as a mapping encodes it.
constexpr std::uint32_t mapped(std::uint16_t index, std::uint8_t sub, unsigned bits) {
  return static_cast<std::uint32_t>(index) << 16U | static_cast<std::uint32_t>(sub) << 8U | bits;
}

namespace detail {

constexpr unsigned ro = readable;
constexpr unsigned rw = readable | operated;
constexpr unsigned kept = rw | stored;
constexpr unsigned kept_set_up = readable | set_up | stored;
constexpr unsigned fixed = readable | constant;

struct PdoDefaults {
  std::uint32_t cob;
  std::uint8_t type;
  std::uint16_t event_ms;
  std::array<std::uint32_t, 3> map;
  std::uint16_t inhibit_100us = 0;
};

// The first two PDOs are as ros2_canopen configures a drive. 2200h are live values in REAL32, which
// change in each step: an inhibit time of 20 ms limits their frames.
inline constexpr std::array<PdoDefaults, pdo_count> rpdo_defaults{{
    {0x200, 255, 0, {mapped(index::controlword, 0, 16), mapped(index::mode, 0, 8)}},
    {0x300, 255, 0, {mapped(index::target_position, 0, 32), mapped(index::target_velocity, 0, 32)}},
    {0x400 | cob_invalid, 255, 0, {}},
    {0x500 | cob_invalid, 255, 0, {}},
}};
inline constexpr std::array<PdoDefaults, pdo_count> tpdo_defaults{{
    {0x180 | cob_no_remote,
     255,
     100,
     {mapped(index::statusword, 0, 16), mapped(index::mode_display, 0, 8),
      mapped(index::error_code, 0, 16)}},
    {0x280 | cob_no_remote,
     1,
     0,
     {mapped(index::position_actual, 0, 32), mapped(index::velocity_actual, 0, 32)}},
    {0x380 | cob_no_remote | cob_invalid,
     255,
     100,
     {mapped(0x2200, 10, 32), mapped(0x2200, 3, 32)},
     200},
    {0x480 | cob_no_remote | cob_invalid,
     255,
     100,
     {mapped(0x2200, 6, 32), mapped(0x2200, 9, 32)},
     200},
}};

template <bool transmit>
constexpr auto pdo_rows(std::size_t i) {
  constexpr std::uint16_t base = transmit ? index::tpdo_communication : index::rpdo_communication;
  constexpr unsigned access = transmit ? kept : kept_set_up;
  constexpr std::size_t first =
      transmit ? offsetof(Communication, tpdo) : offsetof(Communication, rpdo);
  const std::size_t at = first + i * sizeof(PdoParams);
  const PdoDefaults& d = transmit ? tpdo_defaults[i] : rpdo_defaults[i];
  const auto index = static_cast<std::uint16_t>(base + i);
  const auto params = std::to_array<DescribedObject>({
      row({index, 1}, Type::u32, access | by_node, at + offsetof(PdoParams, cob), "COB-ID", d.cob),
      row({index, 2}, Type::u8, access, at + offsetof(PdoParams, type), "Transmission type",
          d.type),
      row({index, 3}, Type::u16, access, at + offsetof(PdoParams, inhibit_100us), "Inhibit time",
          d.inhibit_100us, "in units of 100 us"),
      row({index, 5}, Type::u16, access, at + offsetof(PdoParams, event_ms), "Event timer",
          d.event_ms,
          transmit ? "ms; longest time between two of these PDOs; 0: no limit"
                   : "ms; time without this PDO until it has timed out; 0: never"),
      row({index, 6}, Type::u8, access, at + offsetof(PdoParams, sync_start), "SYNC start value", 0,
          0, 240),
  });
  constexpr std::size_t n = transmit ? 5 : 4;
  std::array<DescribedObject, n> rows{};
  std::ranges::copy(params.begin(), params.begin() + n, rows.begin());
  return rows;
}

inline constexpr std::array<std::string_view, mapped_count> mapped_names{
    "Object 1", "Object 2", "Object 3", "Object 4", "Object 5", "Object 6", "Object 7", "Object 8"};

template <bool transmit>
constexpr auto mapping_rows(std::size_t i) {
  constexpr std::uint16_t base = transmit ? index::tpdo_mapping : index::rpdo_mapping;
  constexpr unsigned access = transmit ? kept : kept_set_up;
  constexpr std::size_t first =
      transmit ? offsetof(Communication, tpdo_map) : offsetof(Communication, rpdo_map);
  const std::size_t at = first + i * sizeof(Mapping);
  const auto& map = (transmit ? tpdo_defaults[i] : rpdo_defaults[i]).map;
  const auto index = static_cast<std::uint16_t>(base + i);
  std::array<DescribedObject, mapped_count + 1> rows{};
  const auto count = static_cast<std::uint32_t>(
      std::ranges::count_if(map, [](std::uint32_t object) { return object != 0; }));
  rows[0] = row({index, 0}, Type::u8, access, at + offsetof(Mapping, count),
                "Number of mapped objects", count, 0, mapped_count);
  for (std::size_t k = 0; k < mapped_count; ++k) {
    rows[k + 1] =
        row({index, static_cast<std::uint8_t>(k + 1)}, Type::u32, access,
            at + offsetof(Mapping, objects) + 4 * k, mapped_names[k], k < map.size() ? map[k] : 0);
  }
  return rows;
}

constexpr std::size_t at_of(std::size_t array, std::size_t i) {
  return array + 4 * i;
}

inline constexpr auto head_rows = std::to_array<DescribedObject>({
    row({index::device_type, 0}, Type::u32, fixed, offsetof(Communication, device_type),
        "Device type"),
    row({index::error_register, 0}, Type::u8, ro | in_tpdo, offsetof(Communication, error_register),
        "Error register"),
    row({index::error_field, 0}, Type::u8, rw, offsetof(Communication, error_count),
        "Number of errors", 0, 0, error_history, "writing 0 clears the list"),
    row({index::error_field, 1}, Type::u32, ro, at_of(offsetof(Communication, errors), 0),
        "Error 1"),
    row({index::error_field, 2}, Type::u32, ro, at_of(offsetof(Communication, errors), 1),
        "Error 2"),
    row({index::error_field, 3}, Type::u32, ro, at_of(offsetof(Communication, errors), 2),
        "Error 3"),
    row({index::error_field, 4}, Type::u32, ro, at_of(offsetof(Communication, errors), 3),
        "Error 4"),
    row({index::error_field, 5}, Type::u32, ro, at_of(offsetof(Communication, errors), 4),
        "Error 5"),
    row({index::error_field, 6}, Type::u32, ro, at_of(offsetof(Communication, errors), 5),
        "Error 6"),
    row({index::error_field, 7}, Type::u32, ro, at_of(offsetof(Communication, errors), 6),
        "Error 7"),
    row({index::error_field, 8}, Type::u32, ro, at_of(offsetof(Communication, errors), 7),
        "Error 8"),
    row({index::sync_cob_id, 0}, Type::u32, kept_set_up, offsetof(Communication, sync_cob),
        "COB-ID SYNC", 0x80),
    row({index::sync_period, 0}, Type::u32, kept_set_up, offsetof(Communication, sync_period_us),
        "Communication cycle period", 0,
        "us; after two periods without a SYNC the command source has gone; 0: not watched"),
    row({index::device_name, 0}, Type::text, fixed, nowhere, "Manufacturer device name"),
    row({index::hardware_version, 0}, Type::text, fixed, nowhere, "Manufacturer hardware version"),
    row({index::software_version, 0}, Type::text, fixed, nowhere, "Manufacturer software version"),
    row({index::store_parameters, 1}, Type::u32, readable | tuned, nowhere, "Save all parameters",
        1, "write 'save': 65766173h"),
    row({index::store_parameters, 2}, Type::u32, readable | tuned, nowhere,
        "Save communication parameters", 1, "write 'save': 65766173h"),
    row({index::store_parameters, 3}, Type::u32, readable | tuned, nowhere,
        "Save application parameters", 1, "write 'save': 65766173h"),
    row({index::restore_defaults, 1}, Type::u32, readable | set_up, nowhere,
        "Restore all default parameters", 1, "write 'load': 64616F6Ch; then reset"),
    row({index::restore_defaults, 2}, Type::u32, readable | set_up, nowhere,
        "Restore communication default parameters", 1, "write 'load': 64616F6Ch; then reset"),
    row({index::restore_defaults, 3}, Type::u32, readable | set_up, nowhere,
        "Restore application default parameters", 1, "write 'load': 64616F6Ch; then reset"),
    row({index::emergency_cob_id, 0}, Type::u32, kept | by_node,
        offsetof(Communication, emergency_cob), "COB-ID EMCY", 0x80),
    row({index::emergency_inhibit_time, 0}, Type::u16, kept,
        offsetof(Communication, emergency_inhibit_100us), "Inhibit time EMCY", 100,
        "in units of 100 us"),
    row({index::heartbeat_consumer, 1}, Type::u32, kept_set_up,
        at_of(offsetof(Communication, consumers), 0), "Consumer heartbeat time 1", 0,
        "node-id << 16 | longest time between heartbeats in ms"),
    row({index::heartbeat_consumer, 2}, Type::u32, kept_set_up,
        at_of(offsetof(Communication, consumers), 1), "Consumer heartbeat time 2"),
    row({index::heartbeat_consumer, 3}, Type::u32, kept_set_up,
        at_of(offsetof(Communication, consumers), 2), "Consumer heartbeat time 3"),
    row({index::heartbeat_consumer, 4}, Type::u32, kept_set_up,
        at_of(offsetof(Communication, consumers), 3), "Consumer heartbeat time 4"),
    row({index::heartbeat_producer, 0}, Type::u16, kept, offsetof(Communication, heartbeat_ms),
        "Producer heartbeat time", 0, "ms; 0: none"),
    row({index::identity, 1}, Type::u32, fixed, at_of(offsetof(Communication, identity), 0),
        "Vendor-ID"),
    row({index::identity, 2}, Type::u32, fixed, at_of(offsetof(Communication, identity), 1),
        "Product code"),
    row({index::identity, 3}, Type::u32, fixed, at_of(offsetof(Communication, identity), 2),
        "Revision number"),
    row({index::identity, 4}, Type::u32, ro, at_of(offsetof(Communication, identity), 3),
        "Serial number"),
    row({index::sync_overflow, 0}, Type::u8, kept_set_up, offsetof(Communication, sync_overflow),
        "Synchronous counter overflow value", 0, 0, 240),
    row({0x1020, 1}, Type::u32, kept, at_of(offsetof(Communication, verify), 0),
        "Configuration date", 0, "set to 0 by any change that can be stored"),
    row({0x1020, 2}, Type::u32, kept, at_of(offsetof(Communication, verify), 1),
        "Configuration time"),
    row({0x1021, 0}, Type::domain, ro, nowhere, "Store EDS"),
    row({0x1022, 0}, Type::u16, ro, nowhere, "Store format", 0, "0: plain text"),
    row({0x1029, 1}, Type::u8, kept_set_up, offsetof(Communication, error_behaviour),
        "Communication error", 0, 0, 2, "0: pre-operational, 1: no change, 2: stopped"),
    row({index::sdo_server, 1}, Type::u32, ro | by_node, at_of(offsetof(Communication, sdo_cob), 0),
        "COB-ID client to server", 0x600),
    row({index::sdo_server, 2}, Type::u32, ro | by_node, at_of(offsetof(Communication, sdo_cob), 1),
        "COB-ID server to client", 0x580),
});

template <class T, std::size_t... n>
constexpr auto appended(const std::array<T, n>&... parts) {
  std::array<T, (n + ...)> all{};
  auto at = all.begin();
  ((at = std::ranges::copy(parts, at).out), ...);
  return all;
}

}  // namespace detail

inline constexpr auto communication_rows = detail::appended(
    detail::head_rows, detail::pdo_rows<false>(0), detail::pdo_rows<false>(1),
    detail::pdo_rows<false>(2), detail::pdo_rows<false>(3), detail::mapping_rows<false>(0),
    detail::mapping_rows<false>(1), detail::mapping_rows<false>(2), detail::mapping_rows<false>(3),
    detail::pdo_rows<true>(0), detail::pdo_rows<true>(1), detail::pdo_rows<true>(2),
    detail::pdo_rows<true>(3), detail::mapping_rows<true>(0), detail::mapping_rows<true>(1),
    detail::mapping_rows<true>(2), detail::mapping_rows<true>(3));
static_assert(in_order(communication_rows));

inline constexpr auto communication_names = std::to_array<IndexName>({
    {index::error_field, "Pre-defined error field"},
    {index::store_parameters, "Store parameters"},
    {index::restore_defaults, "Restore default parameters"},
    {index::heartbeat_consumer, "Consumer heartbeat time"},
    {index::identity, "Identity object"},
    {0x1020, "Verify configuration"},
    {0x1029, "Error behaviour"},
    {index::sdo_server, "SDO server parameter"},
    {index::rpdo_communication, "RPDO communication parameter 1"},
    {index::rpdo_communication + 1, "RPDO communication parameter 2"},
    {index::rpdo_communication + 2, "RPDO communication parameter 3"},
    {index::rpdo_communication + 3, "RPDO communication parameter 4"},
    {index::rpdo_mapping, "RPDO mapping parameter 1"},
    {index::rpdo_mapping + 1, "RPDO mapping parameter 2"},
    {index::rpdo_mapping + 2, "RPDO mapping parameter 3"},
    {index::rpdo_mapping + 3, "RPDO mapping parameter 4"},
    {index::tpdo_communication, "TPDO communication parameter 1"},
    {index::tpdo_communication + 1, "TPDO communication parameter 2"},
    {index::tpdo_communication + 2, "TPDO communication parameter 3"},
    {index::tpdo_communication + 3, "TPDO communication parameter 4"},
    {index::tpdo_mapping, "TPDO mapping parameter 1"},
    {index::tpdo_mapping + 1, "TPDO mapping parameter 2"},
    {index::tpdo_mapping + 2, "TPDO mapping parameter 3"},
    {index::tpdo_mapping + 3, "TPDO mapping parameter 4"},
});

/// Identifiers that no object may be given: CiA 301, "restricted CAN-IDs".
constexpr bool is_restricted(std::uint32_t id) {
  return id < 0x80 || (0x101 <= id && id <= 0x180) || (0x581 <= id && id <= 0x5FF) ||
         (0x601 <= id && id <= 0x67F) || (0x6E0 <= id && id <= 0x6FF) || 0x701 <= id;
}

}  // namespace smaservo::canopen

#pragma once
// The indices that CiA 301 (communication) and CiA 402 (drives) give to objects, by their names
// there.

#include <cstdint>

namespace smaservo::canopen::index {

using Index = std::uint16_t;

// CiA 301.
inline constexpr Index device_type = 0x1000;
inline constexpr Index error_register = 0x1001;
inline constexpr Index error_field = 0x1003;
inline constexpr Index sync_cob_id = 0x1005;
inline constexpr Index sync_period = 0x1006;
inline constexpr Index device_name = 0x1008;
inline constexpr Index hardware_version = 0x1009;
inline constexpr Index software_version = 0x100A;
inline constexpr Index store_parameters = 0x1010;
inline constexpr Index restore_defaults = 0x1011;
inline constexpr Index emergency_cob_id = 0x1014;
inline constexpr Index emergency_inhibit_time = 0x1015;
inline constexpr Index heartbeat_consumer = 0x1016;
inline constexpr Index heartbeat_producer = 0x1017;
inline constexpr Index identity = 0x1018;
inline constexpr Index sync_overflow = 0x1019;
inline constexpr Index sdo_server = 0x1200;
// Of the first PDO; the others follow.
inline constexpr Index rpdo_communication = 0x1400;
inline constexpr Index rpdo_mapping = 0x1600;
inline constexpr Index tpdo_communication = 0x1800;
inline constexpr Index tpdo_mapping = 0x1A00;

// CiA 402.
inline constexpr Index connection_option = 0x6007;
inline constexpr Index error_code = 0x603F;
inline constexpr Index controlword = 0x6040;
inline constexpr Index statusword = 0x6041;
inline constexpr Index quick_stop_option = 0x605A;
inline constexpr Index shutdown_option = 0x605B;
inline constexpr Index disable_option = 0x605C;
inline constexpr Index halt_option = 0x605D;
inline constexpr Index fault_option = 0x605E;
inline constexpr Index mode = 0x6060;
inline constexpr Index mode_display = 0x6061;
inline constexpr Index position_demand = 0x6062;
inline constexpr Index position_actual = 0x6064;
inline constexpr Index following_window = 0x6065;
inline constexpr Index following_time = 0x6066;
inline constexpr Index position_window = 0x6067;
inline constexpr Index position_time = 0x6068;
inline constexpr Index velocity_actual = 0x606C;
inline constexpr Index target_torque = 0x6071;
inline constexpr Index rated_torque = 0x6076;
inline constexpr Index torque_actual = 0x6077;
inline constexpr Index target_position = 0x607A;
inline constexpr Index home_offset = 0x607C;
inline constexpr Index position_limit = 0x607D;
inline constexpr Index profile_velocity = 0x6081;
inline constexpr Index torque_slope = 0x6087;
inline constexpr Index homing_method = 0x6098;
inline constexpr Index position_unit = 0x60A8;
inline constexpr Index velocity_unit = 0x60A9;
inline constexpr Index interpolation_period = 0x60C2;
inline constexpr Index supported_homing = 0x60E3;
inline constexpr Index following_error = 0x60F4;
inline constexpr Index target_velocity = 0x60FF;

}  // namespace smaservo::canopen::index

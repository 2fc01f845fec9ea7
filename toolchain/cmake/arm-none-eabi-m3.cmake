# Cortex-M3, without a floating-point unit.
set(SMASERVO_MCU m3)
set(SMASERVO_MCU_FLAGS "-mcpu=cortex-m3 -mfloat-abi=soft")
set(SMASERVO_MCU_MACHINE mps2-an385)
set(SMASERVO_MCU_CLOCK_NS 40)
set(SMASERVO_MCU_MEMORY mps2)
include("${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake")

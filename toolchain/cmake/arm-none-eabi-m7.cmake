# Cortex-M7 with double precision.
set(SMASERVO_MCU m7)
set(SMASERVO_MCU_FLAGS "-mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16")
set(SMASERVO_MCU_MACHINE mps2-an500)
set(SMASERVO_MCU_CLOCK_NS 40)
set(SMASERVO_MCU_MEMORY mps2)
include("${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake")

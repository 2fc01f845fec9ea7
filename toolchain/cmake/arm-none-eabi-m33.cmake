# Cortex-M33 with single precision.
set(SMASERVO_MCU m33)
set(SMASERVO_MCU_FLAGS "-mcpu=cortex-m33 -mfloat-abi=hard -mfpu=fpv5-sp-d16")
set(SMASERVO_MCU_MACHINE mps2-an505)
set(SMASERVO_MCU_CLOCK_NS 50)
set(SMASERVO_MCU_MEMORY mps2-an505)
include("${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake")

# Cortex-M4 with single precision.
set(SMASERVO_MCU m4f)
set(SMASERVO_MCU_FLAGS "-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16")
set(SMASERVO_MCU_MACHINE mps2-an386)
set(SMASERVO_MCU_CLOCK_NS 40)
set(SMASERVO_MCU_MEMORY mps2)
include("${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake")

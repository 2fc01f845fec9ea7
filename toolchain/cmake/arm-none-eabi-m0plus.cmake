# Cortex-M0+. QEMU has no board of its own for it; an M3 runs its code.
set(SMASERVO_MCU m0plus)
set(SMASERVO_MCU_FLAGS "-mcpu=cortex-m0plus -mfloat-abi=soft")
set(SMASERVO_MCU_MACHINE mps2-an385)
set(SMASERVO_MCU_CLOCK_NS 40)
set(SMASERVO_MCU_MEMORY mps2)
include("${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake")

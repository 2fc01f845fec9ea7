# Cross compiling for a Cortex-M without an operating system. A file beside this one names core,
# processor flags and the board that QEMU emulates, and includes it.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_CXX_FLAGS_INIT "-mthumb ${SMASERVO_MCU_FLAGS}")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-nostartfiles --specs=nano.specs")
set(CMAKE_CROSSCOMPILING_EMULATOR
  qemu-system-arm -M "${SMASERVO_MCU_MACHINE}" -nographic -monitor none -serial none
  -semihosting-config enable=on,target=native -kernel)

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

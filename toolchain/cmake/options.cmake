# Compiler options of every target: link smaservo_options privately.

add_library(smaservo_options INTERFACE)
target_include_directories(smaservo_options INTERFACE "${PROJECT_SOURCE_DIR}")

target_compile_options(smaservo_options INTERFACE
  -Wall -Wextra -Wpedantic -Werror
  -Wconversion -Wsign-conversion -Wdouble-promotion -Wshadow -Wnon-virtual-dtor
  -Woverloaded-virtual -Wold-style-cast -Wcast-qual -Wformat=2 -Wimplicit-fallthrough -Wvla
  # One rounding for each operation, on every machine: a replay gives the same bits.
  -ffp-contract=off
  # No errno from sqrt, no traps: neither changes a result, both cost instructions.
  -fno-math-errno -fno-trapping-math)

# g++ 12 sees overlapping copies in std::string's operator+ where there are none (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(smaservo_options INTERFACE -Wno-restrict)
endif()

# Without an operating system there is nothing that could catch, and nothing to take memory from.
if(CMAKE_SYSTEM_NAME STREQUAL "Generic")
  target_compile_options(smaservo_options INTERFACE
    -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-unwind-tables
    -fno-asynchronous-unwind-tables -ffunction-sections -fdata-sections -fstack-usage)
  target_compile_definitions(smaservo_options INTERFACE EIGEN_NO_MALLOC EIGEN_DONT_VECTORIZE)
  target_link_options(smaservo_options INTERFACE -Wl,--gc-sections -Wl,--fatal-warnings
    -Wl,--no-warn-rwx-segments)
endif()

if(SMASERVO_SANITIZE)
  target_compile_options(smaservo_options INTERFACE
    -fsanitize=${SMASERVO_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  # A null pointer, an object that is too small: address sees them, too, for a quarter of the time
  # that undefined takes to compile. No class here is cast to one that it is derived from.
  if(SMASERVO_SANITIZE MATCHES "undefined")
    target_compile_options(smaservo_options INTERFACE -fno-sanitize=null,object-size,vptr)
  endif()
  # Tests that would take minutes are shorter then.
  target_compile_definitions(smaservo_options INTERFACE SMASERVO_SANITIZED)
  target_link_options(smaservo_options INTERFACE -fsanitize=${SMASERVO_SANITIZE})
endif()

# Reading headers takes longer than compiling the sources that include them, so the sources of one
# room are compiled as one. They see each other's file-local names; those of other rooms they do not.
option(SMASERVO_TOGETHER "compile the sources of a room as one; OFF: each by itself" ON)

if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Memory that is not collected while there is less of it: 1.5 to 13 % of the time of a source.
  target_compile_options(smaservo_options INTERFACE --param=ggc-min-heapsize=524288)
  # g++ takes what a source includes for a header, which might be included elsewhere, too.
  if(SMASERVO_TOGETHER)
    target_compile_options(smaservo_options INTERFACE -Wno-subobject-linkage)
  endif()
endif()

# A room is two folders deep; the papers are three, for they are large. What parses command lines is
# one of its own: CLI11 takes five seconds wherever it is included.
function(smaservo_room_of source room)
  cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" NORMALIZE)
  cmake_path(GET source PARENT_PATH folder)
  cmake_path(RELATIVE_PATH folder BASE_DIRECTORY "${PROJECT_SOURCE_DIR}")
  string(REGEX REPLACE "^tests/" "" folder "${folder}")
  string(REGEX MATCH "^(host-sim/papers/[^/]+|[^/]+(/[^/]+)?)" name "${folder}")
  if(source MATCHES "/host-sim/(.+/[a-z_]+_command|commands/commands|options)[.]cpp$")
    set(name commands)
  endif()
  string(MAKE_C_IDENTIFIER "${name}" name)
  set(${room} "${name}" PARENT_SCOPE)
endfunction()

# The sources that a target was given, before they were compiled together.
define_property(TARGET PROPERTY SMASERVO_SOURCES)

# One source a room, which includes all of the room's. CMake's own unity builds name them by absolute
# paths; here they are relative to the project, so that ccache knows them again in another clone. What
# a command of the build makes stays a source by itself.
function(smaservo_compile_together target)
  get_target_property(sources ${target} SOURCES)
  set_target_properties(${target} PROPERTIES SMASERVO_SOURCES "${sources}")
  if(NOT SMASERVO_TOGETHER)
    return()
  endif()
  set(rooms "")
  set(compiled "")
  foreach(source IN LISTS sources)
    get_source_file_property(generated "${source}" GENERATED)
    if(generated)
      list(APPEND compiled "${source}")
      continue()
    endif()
    smaservo_room_of("${source}" room)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" NORMALIZE)
    cmake_path(IS_PREFIX PROJECT_SOURCE_DIR "${source}" inside)
    if(inside)
      cmake_path(RELATIVE_PATH source BASE_DIRECTORY "${PROJECT_SOURCE_DIR}")
    endif()
    list(APPEND rooms "${room}")
    string(APPEND "text_${room}" "#include \"${source}\"\n")
  endforeach()
  list(REMOVE_DUPLICATES rooms)
  foreach(room IN LISTS rooms)
    set(unit "${CMAKE_CURRENT_BINARY_DIR}/together/${target}/${room}.cpp")
    file(CONFIGURE OUTPUT "${unit}" CONTENT "${text_${room}}" @ONLY)
    list(APPEND compiled "${unit}")
  endforeach()
  set_property(TARGET ${target} PROPERTY SOURCES ${compiled})
endfunction()

# A static library that may become a part of a shared object. None of its functions is replaced by another
# object's, so that calls are inlined as in a program.
function(smaservo_position_independent target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -fno-semantic-interposition)
endfunction()

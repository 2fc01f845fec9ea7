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

# What sources include takes longer than they do. Those of a target that are compiled as one see
# each other's names: one without linkage stands for one thing in the whole target, and a test's
# namespace has the name of its file.
set(SMASERVO_TOGETHER 8 CACHE STRING
    "sources of a target that are compiled as one; 1: each by itself, for a quick change of one")

# g++ takes what a source includes for a header, which might be included elsewhere, too.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND SMASERVO_TOGETHER GREATER 1)
  target_compile_options(smaservo_options INTERFACE -Wno-subobject-linkage)
endif()

function(smaservo_compile_together target)
  if(SMASERVO_TOGETHER GREATER 1)
    set_target_properties(${target} PROPERTIES
      UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${SMASERVO_TOGETHER})
  endif()
endfunction()

# The same by folders, a target's own sources in three parts: the command line's library takes
# longer than all else.
function(smaservo_compile_by_folders target)
  if(SMASERVO_TOGETHER LESS_EQUAL 1)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(source MATCHES "^(.+)/")
      string(REPLACE "/" "_" group "${CMAKE_MATCH_1}")
    elseif(source MATCHES "command")
      set(group commands)
    elseif(source MATCHES "^[a-o]")
      set(group a_to_o)
    else()
      set(group p_to_z)
    endif()
    set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "${group}")
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

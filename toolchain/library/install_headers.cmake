# Run by `cmake --install`: installs the public headers and all that they include.
#
# In the tree a header is "model/units.hpp"; installed it is "smaservo/model/units.hpp", since a program may
# have a folder `model` of its own.
#
# SMASERVO_SOURCE: the project's folder; SMASERVO_HEADERS: the file that lists the public headers;
# SMASERVO_REWRITTEN: a folder for the copies.

cmake_minimum_required(VERSION 3.25)
set(include_of_ours "#include \"((model|observer|hal|firmware)/[^\"]+)\"")
file(STRINGS "${SMASERVO_HEADERS}" wanted REGEX "^[a-z]")
list(TRANSFORM wanted REPLACE "^[a-z]+ +([^ ]+) .*" "\\1")
set(found "")
while(wanted)
  list(POP_FRONT wanted header)
  if(header IN_LIST found)
    continue()
  endif()
  list(APPEND found "${header}")
  if(NOT EXISTS "${SMASERVO_SOURCE}/${header}")
    message(FATAL_ERROR "${SMASERVO_HEADERS}: ${header}, or a header that includes it, names no file of the project")
  endif()
  file(READ "${SMASERVO_SOURCE}/${header}" text)
  string(REGEX MATCHALL "${include_of_ours}" includes "${text}")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "${include_of_ours}" "\\1" included "${include}")
    list(APPEND wanted "${included}")
  endforeach()
  string(REGEX REPLACE "${include_of_ours}" "#include \"smaservo/\\1\"" text "${text}")
  # One that is the same keeps its time, so that a program is not compiled anew.
  file(CONFIGURE OUTPUT "${SMASERVO_REWRITTEN}/smaservo/${header}" CONTENT "${text}" @ONLY)
endwhile()
file(GLOB_RECURSE copies RELATIVE "${SMASERVO_REWRITTEN}/smaservo" "${SMASERVO_REWRITTEN}/smaservo/*")
foreach(copy IN LISTS copies)
  if(NOT copy IN_LIST found)
    file(REMOVE "${SMASERVO_REWRITTEN}/smaservo/${copy}")
  endif()
endforeach()
file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include" TYPE DIRECTORY
  FILES "${SMASERVO_REWRITTEN}/smaservo")

# The target one_definition of the preset odr: the linker reads every class of the programs and their
# libraries, and compares those of one name. It makes no program of them, which would take five times
# as long.

function(smaservo_static_libraries folder result)
  get_property(targets DIRECTORY "${folder}" PROPERTY BUILDSYSTEM_TARGETS)
  get_property(folders DIRECTORY "${folder}" PROPERTY SUBDIRECTORIES)
  set(found "")
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      list(APPEND found ${target})
    endif()
  endforeach()
  foreach(inner IN LISTS folders)
    smaservo_static_libraries("${inner}" inner_found)
    list(APPEND found ${inner_found})
  endforeach()
  set(${result} "${found}" PARENT_SCOPE)
endfunction()

smaservo_static_libraries("${PROJECT_SOURCE_DIR}" libraries)
set(objects $<TARGET_OBJECTS:host-sim> $<TARGET_OBJECTS:smaservo-table>)
if(TARGET smaservod)
  list(APPEND objects $<TARGET_OBJECTS:smaservod>)
endif()
list(TRANSFORM libraries REPLACE ".+" "$<TARGET_FILE:\\0>" OUTPUT_VARIABLE archives)

# Each program has its main().
add_custom_command(OUTPUT one_definition.o
  COMMAND "${CMAKE_CXX_COMPILER}" -O0 -flto -r -flinker-output=rel -Wodr -Werror=odr -Wl,-z,muldefs
    ${objects} -Wl,--whole-archive ${archives} -o one_definition.o
  DEPENDS ${objects} ${libraries}
  COMMENT "Comparing the definitions of each class"
  COMMAND_EXPAND_LISTS VERBATIM)
add_custom_target(one_definition DEPENDS one_definition.o)

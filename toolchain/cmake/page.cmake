# What npm builds of host-sim/page/front, as a source of host-sim (report/assets.hpp). Without npm or
# its registry, strings in it are empty, and the build says so.

option(SMASERVO_PAGE "build the pages of host-sim, for which npm fetches its packages" ON)

# One build for all presets, since none of it depends on them; a build folder elsewhere has its own.
function(smaservo_page_folder result)
  cmake_path(GET PROJECT_BINARY_DIR PARENT_PATH beside)
  if(beside STREQUAL "${PROJECT_SOURCE_DIR}/build")
    set(${result} "${beside}/page" PARENT_SCOPE)
  else()
    set(${result} "${PROJECT_BINARY_DIR}/page" PARENT_SCOPE)
  endif()
endfunction()

# The source, made where `assets_cpp` says.
function(smaservo_page assets_cpp)
  smaservo_page_folder(page)
  set(front "${PROJECT_SOURCE_DIR}/host-sim/page/front")
  set(build "${PROJECT_SOURCE_DIR}/host-sim/page/build.sh")
  set(embed "${PROJECT_SOURCE_DIR}/toolchain/cmake/embed.cmake")
  if(SMASERVO_PAGE)
    # Where npm appears, the command changes, and so the page is built.
    find_program(SMASERVO_NPM npm)
    find_program(SMASERVO_NODE node)
    set(tools "${SMASERVO_NPM}" "${SMASERVO_NODE}")
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${front}/*")
    list(FILTER sources EXCLUDE REGEX "/(node_modules|dist)/")
  else()
    set(page "${PROJECT_BINARY_DIR}/no-page")  # what others have built stays
    set(tools off)
    set(sources "")
  endif()
  add_custom_command(
    OUTPUT "${assets_cpp}"
    COMMAND "${build}" "${front}" "${page}" ${tools}
    COMMAND "${CMAKE_COMMAND}" "-DPAGE=${page}" "-DOUT=${assets_cpp}" -P "${embed}"
    DEPENDS "${build}" "${embed}" ${sources}
    COMMENT "The pages of host-sim"
    VERBATIM)
endfunction()

# Bundles web/viewer into one page and puts it into the given target, as mmlins::view::page(). It needs npm, at build time
# alone, and the packages of web/viewer/package-lock.json from its registry. Where they cannot be had the page is empty,
# all else is built, and `mmlins view` says what is missing.
option(MMLINS_VIEWER "Bundle the page of mmlins view; needs npm" ON)

function(embed_viewer target)
  set(source ${PROJECT_SOURCE_DIR}/web/viewer)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/viewer)
  file(GLOB_RECURSE inputs CONFIGURE_DEPENDS ${source}/src/*)
  list(APPEND inputs ${source}/package.json ${source}/package-lock.json ${source}/tsconfig.json ${source}/build.mjs)
  set(npm "")
  if(MMLINS_VIEWER)
    find_program(NPM npm)
    if(NPM)
      set(npm ${NPM})
    else()
      message(STATUS "npm was not found: mmlins view will not work (Debian: apt-get install nodejs npm)")
    endif()
  endif()
  # Without a page there is no stamp, so that the next build tries again.
  add_custom_command(
    OUTPUT ${folder}/viewer_page.cpp ${folder}/viewer_page.stamp
    COMMAND ${CMAKE_COMMAND} -D npm=${npm} -D source=${source} -D folder=${folder} -P ${PROJECT_SOURCE_DIR}/cmake/bundle_viewer.cmake
    DEPENDS ${inputs} ${PROJECT_SOURCE_DIR}/cmake/bundle_viewer.cmake
    COMMENT "Bundling the page of mmlins view"
    VERBATIM)
  target_sources(${target} PRIVATE ${folder}/viewer_page.cpp)
endfunction()

# Run by the build (embed_viewer.cmake): npm ci if the lock file has changed, bundle, and write the page as C++.
file(MAKE_DIRECTORY ${folder})
set(page "")
set(log ${folder}/npm.log)

function(run_npm result)
  execute_process(COMMAND ${npm} ${ARGN} WORKING_DIRECTORY ${folder} RESULT_VARIABLE code OUTPUT_FILE ${log} ERROR_FILE ${log})
  set(${result} ${code} PARENT_SCOPE)
endfunction()

if(npm)
  file(REMOVE_RECURSE ${folder}/src)
  file(COPY ${source}/src ${source}/package.json ${source}/package-lock.json ${source}/tsconfig.json ${source}/build.mjs DESTINATION ${folder})
  file(SHA256 ${source}/package-lock.json wanted)
  set(installed "")
  if(EXISTS ${folder}/node_modules/.installed)
    file(READ ${folder}/node_modules/.installed installed)
  endif()
  set(code 0)
  if(NOT installed STREQUAL wanted)
    run_npm(code ci --no-audit --no-fund --no-update-notifier)
    if(code EQUAL 0)
      file(WRITE ${folder}/node_modules/.installed ${wanted})
    else()
      message("npm ci failed, so that mmlins view will not work; all else is built. See ${log}")
    endif()
  endif()
  if(code EQUAL 0)
    run_npm(code run --silent build)
    if(NOT code EQUAL 0)
      file(READ ${log} said)
      message(FATAL_ERROR "${said}")
    endif()
    file(READ ${folder}/viewer.html page)
  endif()
endif()

# Compilers limit the length of one literal.
string(LENGTH "${page}" length)
set(literals "")
set(at 0)
while(at LESS length)
  string(SUBSTRING "${page}" ${at} 15000 part)
  string(APPEND literals "    R\"page~(${part})page~\"\n")
  math(EXPR at "${at} + 15000")
endwhile()
if(literals STREQUAL "")
  set(literals "    \"\"\n")
endif()
file(WRITE ${folder}/viewer_page.cpp "// Generated from web/viewer.
#include \"mmlins/view/router.hpp\"

namespace mmlins::view {

std::string_view page() {
  static constexpr char kText[] =
${literals}      ;
  return {kText, sizeof(kText) - 1};
}

}  // namespace mmlins::view
")
if(page)
  file(WRITE ${folder}/viewer_page.stamp "")
else()
  file(REMOVE ${folder}/viewer_page.stamp)
endif()

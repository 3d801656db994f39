# Puts the files of a web page into the given target, so that the program needs no data folder: writes a .cpp that
# defines std::vector<PageFile> mmlins::report::page_files(). Made anew whenever one of them changes.
function(embed_page target folder)
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*.html ${folder}/*.css ${folder}/*.js)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  set(entries "")
  foreach(path ${files})
    get_filename_component(name "${path}" NAME)
    file(READ "${path}" text)
    string(APPEND entries "      {\"${name}\", R\"page(${text})page\"},\n")
  endforeach()
  set(output ${CMAKE_CURRENT_BINARY_DIR}/page_files.cpp)
  file(CONFIGURE OUTPUT ${output} @ONLY CONTENT "// Generated from src/mmlins/report/page.
#include \"mmlins/report/page_files.hpp\"

namespace mmlins::report {

std::vector<PageFile> page_files() {
  return {
@entries@  };
}

}  // namespace mmlins::report
")
  target_sources(${target} PRIVATE ${output})
endfunction()
